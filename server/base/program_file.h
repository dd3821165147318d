// Where this program lies, from which its siblings are found: the importer, the page, modules.
#pragma once

#include <filesystem>

namespace isostrata {

/// The file of the running program; empty if it cannot be told. Not /proc/self/exe, which is the dynamic loader's file if that was
/// started with the program's name (`ld-linux-x86-64.so.2 --library-path LIB PROGRAM`), as the download does (deploy/archive). Any thread.
std::filesystem::path program_file();

/// The dynamic loader's file if it was started with the program's name; empty if the kernel started the program. Any thread.
std::filesystem::path program_loader();

}  // namespace isostrata
