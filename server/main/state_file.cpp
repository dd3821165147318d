#include "main/state_file.h"

#include <fstream>
#include <iterator>

#include "engine/data/dataset_facts.h"
#include "net/http/json_body.h"
#include "session/commands/apply_command.h"
#include "session/wire/limits.h"

namespace isostrata {

Scene read_state_file(const std::string& path, const Dataset& dataset, double aspect) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorCode::not_found, path + ": this file cannot be read");
  std::string text(kMaxMessageBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  const auto refuse = [&](ErrorCode code, const std::string& why) { throw Error(code, path + ": " + why); };
  if (text.size() > kMaxMessageBytes)
    refuse(ErrorCode::too_large, "more than " + std::to_string(kMaxMessageBytes) + " bytes are not a session's state");
  v1::State wanted;
  if (text.empty()) refuse(ErrorCode::bad_data, "the file is empty; expected a session's state as JSON");
  if (const auto error = parse_message(text, wanted))
    refuse(ErrorCode::bad_data, error->message() + "; expected a session's state, as GET api/v1/sessions/ID/state gives it");

  // As a session that opens the dataset and is given the state.
  DatasetFacts facts = dataset_facts(dataset.name, dataset.name, dataset);
  SceneState state;
  open_in_scene(state, facts, aspect);
  wanted.set_dataset(facts.id);
  if (const auto outcome = apply_state(state, wanted, {&facts, aspect}); outcome.error)
    refuse(ErrorCode::invalid_argument, outcome.error->message());
  return state.scene;
}

}  // namespace isostrata
