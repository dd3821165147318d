// What can be opened, without a session.
#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/dataset_list.h"
#include "session/wire/wire.h"

namespace isostrata {

namespace json = boost::json;

namespace {

constexpr std::uint32_t kMostInOneAnswer = 10'000;

void list(RestContext& context, const Call& call) {
  v1::ListDatasets wanted;
  std::uint32_t first = 0, most = kMostListed;
  if (auto error = number_parameter(call, "first", first)) return call.reply(problem(*error));
  if (auto error = number_parameter(call, "most", most)) return call.reply(problem(*error));
  if (most < 1 || most > kMostInOneAnswer)
    return call.reply(problem(wire_error("invalid_argument", "most is " + std::to_string(most) + "; expected 1 to " + std::to_string(kMostInOneAnswer), "most")));
  const std::string tag = "\"datasets-" + std::to_string(context.sessions.catalogue_revision()) + "\"";
  if (call.request.header("if-none-match") == tag) {
    HttpResponse unchanged{304, "", "", {}};
    unchanged.headers.emplace_back("ETag", tag);
    return call.reply(std::move(unchanged));
  }
  wanted.set_folder(call.parameter("folder"));
  wanted.set_search(call.parameter("search"));
  wanted.set_first(first);
  wanted.set_most(most);
  const bool one_level = call.target.query.contains("folder") || call.target.query.contains("search");
  v1::DatasetList answer = one_level ? list_datasets(context.sessions.catalogue(), wanted, kMostInOneAnswer) : all_datasets(context.sessions.catalogue(), first, most);
  answer.set_revision(context.sessions.catalogue_revision());
  answer.set_watching(context.sessions.watching());
  HttpResponse response = message_response(200, answer);
  response.headers.emplace_back("ETag", tag);
  call.reply(std::move(response));
}

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

std::function<void(Call)> numbers_of_dataset(RestContext& context, AnswerNumbers answer) {
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
                    .description =
                        "All of it, or with folder one level, or with search what is named so. Files that come, grow, change and go while the "
                        "server runs are in the next answer; the ETag changes with the list, so If-None-Match makes asking again cheap.",
                    .query = {{"folder", "One level: what lies in this folder itself, and its folders; empty: the served folder"},
                              {"search", "Words of which each is in a name, or in that of a file of a series, below the folder"},
                              {"first", "Folders and datasets that are left out at the beginning", true, 0, UINT32_MAX, "0"},
                              {"most", "How many at most", true, 1, kMostInOneAnswer, "1000"}},
                    .answers = {{200, "The catalogue, or a part of it", "DatasetList"}, {304, "It is still that of If-None-Match", ""}},
                    .handler = [&context](Call call) { list(context, call); }});
  routes.push_back({.method = "GET",
                    .path = "/datasets/{dataset}",
                    .id = "getDataset",
                    .tag = "datasets",
                    .summary = "Grid, bounds, arrays and times of a dataset",
                    .description = "Loads it if it is not loaded. missingRangeSteps counts the steps that the arrays' ranges leave "
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
                    .handler = numbers_of_dataset(context, answer_histogram)});
  routes.push_back({.method = "GET",
                    .path = "/datasets/{dataset}/statistics",
                    .id = "getDatasetStatistics",
                    .tag = "datasets",
                    .summary = "Range, mean and standard deviation of an array at a step",
                    .query = {kArrayParameter, kStepParameter},
                    .answers = {{200, "Moments of the finite values", "Statistics"}},
                    .handler = numbers_of_dataset(context, answer_statistics)});
}

}  // namespace isostrata
