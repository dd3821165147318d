// Datasets as what extracts asks for them: by their steps.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "data/dataset/analytic.h"
#include "extraction/layers/extract_layers.h"

namespace isostrata {

/// Of analytic data, each step made once.
inline StepSource steps_of(const std::string& name) {
  return [name, made = std::make_shared<std::map<int, std::shared_ptr<const Dataset>>>()](int step, const Task&) {
    auto& dataset = (*made)[step];
    if (!dataset) {
      OpenOptions options;
      options.step = step;
      dataset = make_analytic(name, options, Task{});
    }
    return dataset;
  };
}

/// One dataset as every step.
inline StepSource steps_of(const std::shared_ptr<const Dataset>& dataset) {
  return [dataset](int, const Task&) { return dataset; };
}

}  // namespace isostrata
