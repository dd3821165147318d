// Picture files, page by page, as OpenImageIO reads them (data/values/page_reader.h), with errors that name the file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "data/values/page_reader.h"
#include "import/imported/imported.h"

namespace isostrata {

/// What the reader says, with the file's name.
template <class Do>
auto named(const std::string& name, const Do& what) {
  try {
    return what();
  } catch (const std::domain_error& error) {
    throw Error(ErrorCode::unsupported, name + ": " + error.what());
  } catch (const std::runtime_error& error) {
    throw Error(ErrorCode::bad_data, name + ": " + error.what());
  }
}

/// At its first page. Throws unavailable if the module is not there, unsupported and bad_data for what is not read.
std::unique_ptr<PageReader> open_pages(const std::filesystem::path& file);

std::size_t bytes_of(const PageLayout& layout);

/// As VTK calls what it reads of these, by which saved scenes know it.
std::string picture_array_name(const std::filesystem::path& file);

/// Throws bad_data if `stored` bytes cannot hold so many pages, too_large above the limit.
void check_pages(const ReadRequest& request, const PageLayout& layout, std::uint64_t pages, std::uint64_t stored, const std::string& name);

/// How far slices are apart, no picture says: only one alone has its pixels in millimetres. Else all points are 1 apart, and a note says so.
std::array<double, 2> spacing_of(const std::array<double, 2>& said, std::int64_t slices, std::vector<std::string>& notes);

/// Slices with one array: values of all pages, one after the other.
Imported picture_volume(const std::filesystem::path& file, const PageLayout& layout, std::int64_t slices, const std::array<double, 3>& spacing, std::shared_ptr<const void> storage,
                        std::span<const std::byte> values);

}  // namespace isostrata
