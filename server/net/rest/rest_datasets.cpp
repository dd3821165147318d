// What can be opened, without a session.
#include <boost/json/array.hpp>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {

namespace json = boost::json;

namespace {

// Loads the dataset, watched by nobody (session 0), and goes on with its facts.
void with_dataset(RestContext& context, const Call& call, std::function<void(const DatasetFacts& facts)> go_on) {
  const std::string ranges = call.parameter("ranges", "known");
  if (ranges != "known" && ranges != "all")
    return call.reply(problem(
        wire_error("invalid_argument", "ranges '" + ranges.substr(0, 32) + "' is not known; expected known or all", "ranges")));
  give_up_with(call, context, context.sessions.ask(OpenRequest{0, 0, call.path.at("dataset"), ranges == "all"},
                       [reply = call.reply, go_on = std::move(go_on)](const EngineEvent& event, TimePoint) {
                         if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
                         go_on(std::get<DatasetReady>(event).facts);
                       }));
}

// A call whose request is gone when the dataset has come: what later work needs of it, kept.
struct KeptCall {
  HttpRequest request;
  RequestTarget target;
  std::map<std::string, std::string> path;
  HttpReply reply;

  explicit KeptCall(const Call& call) : target(call.target), path(call.path), reply(call.reply) {
    request.gone = call.request.gone;
  }
  Call call() const { return {request, target, path, nullptr, {}, reply}; }
};

using AnswerNumbers = void (*)(RestContext&, const Call&, SessionKey, const DatasetFacts&, int, const std::string&);

std::function<void(Call)> numbers_handler(RestContext& context, AnswerNumbers answer) {
  return [&context, answer](Call call) {
    std::uint32_t step = 0;
    if (auto error = number_parameter(call, "step", step)) return call.reply(problem(*error));
    with_dataset(context, call, [&context, answer, step, kept = KeptCall(call)](const DatasetFacts& facts) {
      answer(context, kept.call(), 0, facts, static_cast<int>(std::min<std::uint32_t>(step, INT32_MAX)),
             facts.arrays.empty() ? "" : facts.arrays.front().name);
    });
  };
}

}  // namespace

const QueryParameter kRangesParameter{
    "ranges", "all: reads every step first, so that the arrays' ranges leave none out", false, 0, 0, "known", {"known", "all"}};

void add_dataset_routes(std::vector<Route>& routes, RestContext& context) {
  routes.push_back({.method = "GET",
                    .path = "/datasets",
                    .id = "listDatasets",
                    .tag = "datasets",
                    .summary = "What can be opened",
                    .answers = {{200, "The catalogue", "Datasets"}},
                    .handler = [&context](Call call) {
                      json::array entries;
                      for (const v1::DatasetEntry& entry : context.sessions.datasets())
                        entries.push_back(json::object{{"id", entry.id()}, {"name", entry.name()}});
                      call.reply(json_response(200, json::object{{"datasets", std::move(entries)}}));
                    }});
  routes.push_back({.method = "GET",
                    .path = "/datasets/{dataset}",
                    .id = "getDataset",
                    .tag = "datasets",
                    .summary = "Grid, bounds, arrays and times of a dataset",
                    .description = "Loads it where it is not loaded. missingRangeSteps counts the steps that the arrays' ranges leave "
                                   "out because nobody has read them yet.",
                    .query = {kRangesParameter},
                    .answers = {{200, "Its description", "DatasetInfo"}},
                    .handler = [&context](Call call) {
                      with_dataset(context, call, [reply = call.reply](const DatasetFacts& facts) {
                        reply(message_response(200, to_wire(facts)));
                      });
                    }});
  routes.push_back({.method = "GET",
                    .path = "/datasets/{dataset}/arrays",
                    .id = "listArrays",
                    .tag = "datasets",
                    .summary = "The arrays of a dataset",
                    .query = {kRangesParameter},
                    .answers = {{200, "Its arrays and their ranges", "Arrays"}},
                    .handler = [&context](Call call) {
                      with_dataset(context, call, [reply = call.reply](const DatasetFacts& facts) {
                        v1::DatasetInfo arrays;
                        *arrays.mutable_arrays() = to_wire(facts).arrays();
                        std::string list;
                        for (const v1::ArrayInfo& array : arrays.arrays())
                          list += (list.empty() ? "" : ",") + message_json(array);
                        reply({200, "application/json", "{\"arrays\":[" + list + "]}", {{"Cache-Control", "no-store"}}});
                      });
                    }});
  const QueryParameter bins{"bins", "How many bins of equal width", true, 1, 4096, "256"};
  routes.push_back({.method = "GET",
                    .path = "/datasets/{dataset}/histogram",
                    .id = "getDatasetHistogram",
                    .tag = "datasets",
                    .summary = "How an array's values are spread at a step",
                    .query = {kArrayParameter, bins, kStepParameter},
                    .answers = {{200, "Counts over the array's range at all steps that are known", "Histogram"}},
                    .handler = numbers_handler(context, answer_histogram)});
  routes.push_back({.method = "GET",
                    .path = "/datasets/{dataset}/statistics",
                    .id = "getDatasetStatistics",
                    .tag = "datasets",
                    .summary = "Range, mean and standard deviation of an array at a step",
                    .query = {kArrayParameter, kStepParameter},
                    .answers = {{200, "Moments of the finite values", "Statistics"}},
                    .handler = numbers_handler(context, answer_statistics)});
}

}  // namespace isostrata
