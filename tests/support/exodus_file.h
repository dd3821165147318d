// Exodus II files (G. Sjaardema et al., "Exodus: A Finite Element Data Model", SAND92-2137) as tests want them.
#pragma once

#include <string>
#include <vector>

#include "support/netcdf_classic.h"

namespace isostrata::testing {

struct ExodusFile {
  struct Block {
    std::string type;  // "HEX8", ...
    int nodes = 0;     // of one element
    std::vector<std::int32_t> connectivity;  // from 1
    int id = 0;        // 0: by its place
  };

  int dimensions = 3;
  std::vector<std::vector<double>> points;  // [np][dimensions]
  std::vector<Block> blocks;
  std::vector<std::vector<std::int32_t>> node_sets;      // from 1
  std::vector<double> times;
  std::vector<std::string> node_arrays, element_arrays;  // their values are node_value and element_value

  static double node_value(std::size_t array, std::size_t step, std::size_t node) {
    return static_cast<double>(100 * array + 10 * step * (node + 1));  // 0 at step 0 in the first array
  }
  static double element_value(std::size_t array, std::size_t step, std::size_t element) {
    return static_cast<double>(1000 + 100 * array + 10 * step + element);
  }

  std::string bytes() const {
    NetcdfClassic file;
    file.attribute("api_version", 5.14f);
    file.attribute("version", 5.14f);
    file.attribute("floating_point_word_size", std::int32_t{8});
    file.attribute("file_size", std::int32_t{1});
    file.dimension("len_string", 33);
    file.dimension("len_line", 81);
    file.dimension("four", 4);
    const int len_name = file.dimension("len_name", 33);
    const int steps = file.dimension("time_step", 0);
    const int axes = file.dimension("num_dim", static_cast<std::uint32_t>(dimensions));
    const auto count_dimension = [&](const std::string& name, std::size_t count) {
      return count == 0 ? -1 : file.dimension(name, static_cast<std::uint32_t>(count));
    };
    const int nodes = count_dimension("num_nodes", points.size());
    std::size_t elements = 0;
    for (const Block& block : blocks) elements += elements_of(block);
    count_dimension("num_elem", elements);
    const int block_count = count_dimension("num_el_blk", blocks.size());
    const int set_count = count_dimension("num_node_sets", node_sets.size());
    const int node_array_count = count_dimension("num_nod_var", node_arrays.size());
    const int element_array_count = count_dimension("num_elem_var", element_arrays.size());
    std::vector<int> block_elements, block_nodes;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const std::string n = std::to_string(b + 1);
      block_elements.push_back(count_dimension("num_el_in_blk" + n, elements_of(blocks[b])));
      block_nodes.push_back(count_dimension("num_nod_per_el" + n, elements_of(blocks[b]) ? static_cast<std::size_t>(blocks[b].nodes) : 0));
    }

    file.variable("time_whole", {steps}, times);
    if (nodes >= 0)
      for (int a = 0; a < dimensions; ++a) {
        std::vector<double> along;
        for (const auto& point : points) along.push_back(point[static_cast<std::size_t>(a)]);
        file.variable(std::string("coord") + "xyz"[a], {nodes}, along);
      }
    std::vector<std::string> axis_names{"x", "y", "z"};
    axis_names.resize(static_cast<std::size_t>(dimensions));
    file.text("coor_names", {axes, len_name}, 33, axis_names);
    if (block_count >= 0) {
      std::vector<std::int32_t> status, ids;
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        status.push_back(elements_of(blocks[b]) > 0);
        ids.push_back(blocks[b].id ? blocks[b].id : static_cast<std::int32_t>(b + 1));
      }
      file.variable("eb_status", {block_count}, status);
      file.variable("eb_prop1", {block_count}, ids, "name", "ID");
    }
    for (std::size_t b = 0; b < blocks.size(); ++b)
      if (elements_of(blocks[b]) > 0)
        file.variable("connect" + std::to_string(b + 1), {block_elements[b], block_nodes[b]}, blocks[b].connectivity, "elem_type",
                      blocks[b].type);
    if (set_count >= 0) {
      file.variable("ns_status", {set_count}, std::vector<std::int32_t>(node_sets.size(), 1));
      std::vector<std::int32_t> ids;
      for (std::size_t s = 0; s < node_sets.size(); ++s) ids.push_back(static_cast<std::int32_t>(s + 1));
      file.variable("ns_prop1", {set_count}, ids, "name", "ID");
      for (std::size_t s = 0; s < node_sets.size(); ++s) {
        const int size = file.dimension("num_nod_ns" + std::to_string(s + 1), static_cast<std::uint32_t>(node_sets[s].size()));
        file.variable("node_ns" + std::to_string(s + 1), {size}, node_sets[s]);
      }
    }
    if (node_array_count >= 0) file.text("name_nod_var", {node_array_count, len_name}, 33, node_arrays);
    for (std::size_t a = 0; a < node_arrays.size() && nodes >= 0; ++a) {
      std::vector<double> values;
      for (std::size_t t = 0; t < times.size(); ++t)
        for (std::size_t p = 0; p < points.size(); ++p) values.push_back(node_value(a, t, p));
      file.variable("vals_nod_var" + std::to_string(a + 1), {steps, nodes}, values);
    }
    if (element_array_count >= 0) file.text("name_elem_var", {element_array_count, len_name}, 33, element_arrays);
    for (std::size_t a = 0; a < element_arrays.size(); ++a)
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        if (elements_of(blocks[b]) == 0) continue;
        std::vector<double> values;
        for (std::size_t t = 0; t < times.size(); ++t)
          for (std::size_t e = 0; e < elements_of(blocks[b]); ++e) values.push_back(element_value(a, t, e));
        file.variable("vals_elem_var" + std::to_string(a + 1) + "eb" + std::to_string(b + 1), {steps, block_elements[b]}, values);
      }
    return file.bytes(static_cast<std::uint32_t>(times.size()));
  }

 private:
  static std::size_t elements_of(const Block& block) {
    return block.nodes ? block.connectivity.size() / static_cast<std::size_t>(block.nodes) : 0;
  }
};

}  // namespace isostrata::testing
