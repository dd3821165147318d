// The rule of the rooms, as a check over the sources: which room may include which.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace isostrata {

/// The rooms of server/ in order: a room may include itself and the rooms before it.
const std::vector<std::string>& rooms();

/// Reads every .h, .cpp, .glsl, .vert, .frag and .comp below root/server, root/client and root/protocol and returns one line for
/// each thing against the rules, sorted; empty if all is well:
///   - an include of a room to the right, or of a room that does not exist;
///   - server/import (an executable of its own) including a room beyond data;
///   - an include of a server room in client/, or of protobuf's generated header to the left of session;
///   - a file named for nothing (util, utils, common, helper, helpers, manager, misc);
///   - a .proto file that is not proto3;
///   - a folder in server/ that is not a room;
///   - in a room whose CMakeLists.txt lists FOLDERS, in order: an include of a folder further down the list, a source in none of them, a
///     folder that is not listed, a listed folder without a source;
///   - two headers that define a type of the same name.
/// Throws std::runtime_error where root has no server folder.
std::vector<std::string> broken_arrows(const std::filesystem::path& root);

}  // namespace isostrata
