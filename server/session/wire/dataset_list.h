// The catalogue as clients browse it: folder by folder, by words, a part at a time.
#pragma once

#include "engine/data/catalogue.h"
#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {

constexpr std::uint32_t kMostListed = 1000;  // of one answer on the WebSocket, and in Welcome

v1::DatasetEntry to_wire(const CatalogueEntry& entry);

/// What ListDatasets asks for, at most `most` rows, without what only the server knows: in_reply_to, revision, watching. Linear in the number of entries.
v1::DatasetList list_datasets(const Catalogue& catalogue, const v1::ListDatasets& wanted, std::uint32_t most = kMostListed);

/// All entries in their own order, of which the first `first` are left out.
v1::DatasetList all_datasets(const Catalogue& catalogue, std::uint32_t first, std::uint32_t most);

}  // namespace isostrata
