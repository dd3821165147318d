// Which datasets there are, and by which names the engine knows them. Clients, the journal and the sessions know a dataset by its id; the
// engine knows its versions, and is told of those that are used, not of the hundred thousand files beside them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "engine/data/catalogue.h"
#include "engine/messages/messages.h"
#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {

/// Of one server. Not thread-safe: lives on the io thread.
class DatasetVersions {
 public:
  /// follows_files: the catalogue will be replaced by newer ones, and `tell` the engine of an entry, under its version_id, before it is
  /// asked for; else the engine knows all by their ids. watching: as DatasetList's.
  DatasetVersions(std::shared_ptr<const Catalogue> catalogue, std::string watching, bool follows_files, std::function<void(CatalogueEntry)> tell);

  const Catalogue& catalogue() const { return *catalogue_; }
  /// Grows with every change of it.
  std::uint64_t revision() const { return revision_; }
  const std::string& watching() const { return watching_; }
  /// Another catalogue from now on. The engine is told what has changed of the versions that it knows.
  void replace(std::shared_ptr<const Catalogue> catalogue, std::string watching);
  /// That the catalogue is another, as everyone is told.
  v1::ServerMessage news() const;
  v1::ServerMessage list(const v1::ListDatasets& wanted, std::uint64_t in_reply_to) const;

  /// What the catalogue says of a dataset, or of what it is a part of; null: nothing, or nothing follows the files.
  const CatalogueEntry* entry(const std::string& dataset) const;
  /// The id by which the engine knows the newest version of it (version_id), and is told of it if it is new.
  std::string newest(const std::string& dataset);
  /// Names datasets in the request as the engine knows them: the version that the session shows, if it shows one of this dataset, else
  /// the newest. shown: an engine's id, or empty.
  void name_for_engine(EngineRequest& request, const std::function<std::string(SessionKey)>& shown);
  /// The event as everyone else knows the dataset; nothing if it is so already.
  std::optional<EngineEvent> name_for_clients(const EngineEvent& event) const;

 private:
  std::shared_ptr<const Catalogue> catalogue_;
  std::uint64_t revision_ = 1;
  std::string watching_;
  const bool follows_files_;
  const std::function<void(CatalogueEntry)> tell_;
  std::map<std::string, CatalogueEntry> told_;  // of what the engine knows, by version_id
};

}  // namespace isostrata
