// Values that stand for "nothing here", mostly though nothing in the file says so: -9999, 1e30 and the like. One of them makes a histogram useless, and cells beside it have surfaces that are none.
#pragma once

#include "import/imported/imported.h"

namespace isostrata {

/// Makes NaN of the lowest or the highest value of an array, in all blocks, with a note, if it is one that is customary for this, is there more than once, lies apart from all others (by as much as these
/// span; powers of ten by a thousand times that), and the others are not few values, as numbers of materials are. Whole numbers become real ones. Of an array of many values every n-th is looked at
/// first. One that does not fit into memory once more stays as it is.
void leave_out_missing(Imported& imported, const ReadRequest& request);

/// Makes NaN of one value that the file names. Whole numbers become real ones if it is among them.
void leave_out_value(FileArray& array, double none);

}  // namespace isostrata
