#include "session/datasets/dataset_versions.h"

#include <utility>
#include <vector>

#include "session/wire/dataset_list.h"

namespace isostrata {

DatasetVersions::DatasetVersions(std::shared_ptr<const Catalogue> catalogue, std::string watching, bool follows_files,
                                 std::function<void(CatalogueEntry)> tell)
    : catalogue_(std::move(catalogue)), watching_(std::move(watching)), follows_files_(follows_files), tell_(std::move(tell)) {}

void DatasetVersions::replace(std::shared_ptr<const Catalogue> catalogue, std::string watching) {
  catalogue_ = std::move(catalogue);
  watching_ = std::move(watching);
  ++revision_;
  std::vector<std::string> told;
  for (const auto& [id, entry] : told_)
    if (const CatalogueEntry* found = catalogue_->find(plain_id(id)); found && version_id(*found) == id) told.push_back(found->id);
  for (const std::string& id : told) newest(id);
}

v1::ServerMessage DatasetVersions::news() const {
  v1::ServerMessage message;
  message.mutable_datasets_changed()->set_all(static_cast<std::uint32_t>(catalogue_->entries().size()));
  for (const CatalogueEntry& of : catalogue_->latest()) *message.mutable_datasets_changed()->add_entries() = to_wire(of);
  message.mutable_datasets_changed()->set_revision(revision_);
  return message;
}

v1::ServerMessage DatasetVersions::list(const v1::ListDatasets& wanted, std::uint64_t in_reply_to) const {
  v1::ServerMessage answer;
  *answer.mutable_dataset_list() = list_datasets(*catalogue_, wanted);
  answer.mutable_dataset_list()->set_in_reply_to(in_reply_to);
  answer.mutable_dataset_list()->set_revision(revision_);
  answer.mutable_dataset_list()->set_watching(watching_);
  return answer;
}

const CatalogueEntry* DatasetVersions::entry(const std::string& dataset) const {
  return follows_files_ ? catalogue_->find(whole_id(plain_id(dataset))) : nullptr;
}

std::string DatasetVersions::newest(const std::string& dataset) {
  const CatalogueEntry* found = entry(dataset);
  if (!found) return dataset;
  CatalogueEntry named = *found;
  named.id = version_id(*found);
  const auto [at, first] = told_.try_emplace(named.id, named);
  if (first || at->second.mark != named.mark || at->second.parts != named.parts || at->second.source != named.source) {
    at->second = named;
    tell_(named);
  }
  return with_part_of(dataset, named.id);
}

void DatasetVersions::name_for_engine(EngineRequest& request, const std::function<std::string(SessionKey)>& shown) {
  if (!follows_files_) return;
  const auto name = [&](SessionKey key, std::string& dataset) {
    if (dataset.empty() || dataset.find('~') != std::string::npos) return;
    const std::string version = key ? shown(key) : std::string();
    dataset = plain_id(version) == dataset ? version : newest(dataset);
  };
  std::visit(
      [&](auto& r) {
        if constexpr (requires { r.dataset; }) name(r.session, r.dataset);
        if constexpr (requires { r.scene.dataset; }) name(r.session, r.scene.dataset);
      },
      request);
}

std::optional<EngineEvent> DatasetVersions::name_for_clients(const EngineEvent& event) const {
  if (!follows_files_) return std::nullopt;
  std::optional<EngineEvent> renamed;
  if (const auto* ready = std::get_if<DatasetReady>(&event); ready && ready->facts.id.find('~') != std::string::npos) {
    renamed = event;
    std::get<DatasetReady>(*renamed).facts.id = plain_id(ready->facts.id);
  } else if (const auto* counted = std::get_if<HistogramReady>(&event)) {
    renamed = event;
    std::get<HistogramReady>(*renamed).dataset = plain_id(counted->dataset);
  } else if (const auto* summed = std::get_if<StatisticsReady>(&event)) {
    renamed = event;
    std::get<StatisticsReady>(*renamed).dataset = plain_id(summed->dataset);
  }
  return renamed;
}

}  // namespace isostrata
