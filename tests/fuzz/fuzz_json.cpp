// JSON bodies to every route that takes one. The first byte chooses the route; the rest is the body.
#include <cstdint>
#include <cstdlib>

#include "fuzz/fake_engine.h"
#include "net/rest/rest_api.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace isostrata;
  if (size == 0) return 0;
  static fuzz::FakeEngine engine;
  static RestApi api(engine.sessions);  // making its document takes a while; each input has a session of its own
  v1::Error error;
  Session* session = engine.sessions.create(std::chrono::steady_clock::now(), error);
  session->open("fin", nullptr, std::chrono::steady_clock::now(), [](auto) {});
  engine.run();

  std::vector<const Route*> with_body;
  for (const Route& route : api.router().routes())
    if (route.body) with_body.push_back(&route);
  const Route& route = *with_body[data[0] % with_body.size()];
  HttpRequest request;
  request.method = route.method;
  request.body.assign(reinterpret_cast<const char*>(data) + 1, size - 1);
  std::vector<std::string> path = path_segments(route.path);
  for (std::string& segment : path)
    if (segment == "{session}")
      segment = session->id();
    else if (segment.starts_with('{'))
      segment = "1";
  const std::string id = session->id();
  const std::uint64_t revision = session->scene().revision;
  int replies = 0, status = 0;
  api.handle(request, {}, path, [&](HttpResponse response) {
    ++replies;
    status = response.status;
  });
  engine.run();
  fuzz::expect(replies == 1, "every request is answered once");
  fuzz::expect(status < 500 || status == 503, "no body breaks the server");
  // Opening another dataset is done before the state can be judged; all else is done wholly or not at all.
  if (const Session* living = engine.sessions.find(id);
      living && status >= 400 && route.id != "putState" && route.id != "patchState")
    fuzz::expect(living->scene().revision == revision, "what is refused changes nothing");
  fuzz::end_all(engine.sessions);
  return 0;
}
