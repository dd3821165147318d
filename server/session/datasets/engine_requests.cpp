#include "session/datasets/engine_requests.h"

#include <utility>

namespace isostrata {

EngineRequests::EngineRequests(Ports ports, std::shared_ptr<const Catalogue> catalogue, std::string watching, bool follows_files)
    : ports_(std::move(ports)),
      versions_(std::move(catalogue), std::move(watching), follows_files,
                [this](CatalogueEntry entry) { ports_.post(CatalogueUpdate{0, {std::move(entry)}}); }) {}

void EngineRequests::post(EngineRequest request) {
  versions_.name_for_engine(request, ports_.shown);
  ports_.post(std::move(request));
}

RequestId EngineRequests::ask(EngineRequest request, Listener listener) {
  versions_.name_for_engine(request, ports_.shown);
  const RequestId id = pending_.add(session_of(request), std::move(listener));
  std::visit(
      [id](auto& r) {
        if constexpr (requires { r.request; }) r.request = id;
      },
      request);
  ports_.post(std::move(request));
  return id;
}

void EngineRequests::give_up(RequestId request) {
  const auto session = pending_.forget(request);
  if (!session) return;
  ports_.post(CancelRequest{*session, 0, request, true});
  ports_.post(ForgetFrame{*session, request});
}

}  // namespace isostrata
