#include "session/pacing/video_streams.h"

#include <algorithm>

namespace isostrata {

StreamId VideoStreams::of(ViewerKey viewer) const {
  for (const auto& [id, stream] : streams_)
    if (stream.members.contains(viewer)) return id;
  return 0;
}

bool VideoStreams::sociable(ViewerKey viewer, TimePoint now) const {
  const auto past = past_.find(viewer);
  return past == past_.end() || now >= past->second.back_at;
}

bool VideoStreams::has_room(ViewerKey viewer, TimePoint now) const {
  return streams_.size() < kMostStreams || sociable(viewer, now) || of(viewer) != 0;
}

VideoStreams::Choice VideoStreams::choose(ViewerKey viewer, Codec codec, int width, int height, TimePoint now) {
  const StreamId current = of(viewer);
  const auto fits = [&](const Stream& s) { return s.codec == codec && s.width == width && s.height == height; };
  if (current != 0) {
    Stream& mine = streams_[current];
    if (mine.members.size() > 1 && fits(mine)) return {current, !mine.members[viewer]};
  }
  if (sociable(viewer, now))
    for (auto& [id, stream] : streams_)
      if (id != current && fits(stream)) {
        if (stream.key_at && now - *stream.key_at < kKeyPause) continue;
        leave(viewer);
        stream.members[viewer] = false;
        return {id, true};
      }
  if (current != 0) {
    Stream& mine = streams_[current];
    if (mine.members.size() == 1 && mine.codec == codec) {
      // Another size begins with a key frame by itself.
      mine.width = width;
      mine.height = height;
      return {current, false};
    }
    leave(viewer);
  }
  if (streams_.size() >= kMostStreams) return {};
  streams_[++last_] = {codec, width, height, {{viewer, false}}, std::nullopt};
  return {last_, false};
}

void VideoStreams::missed(ViewerKey viewer, TimePoint now) {
  leave(viewer);
  Past& past = past_[viewer];
  past.back_at = now + past.next_pause;
  past.next_pause = std::min(2 * past.next_pause, kLastReturn);
}

void VideoStreams::leave(ViewerKey viewer, bool gone) {
  if (gone) past_.erase(viewer);
  for (auto it = streams_.begin(); it != streams_.end(); ++it) {
    if (it->second.members.erase(viewer) == 0) continue;
    if (it->second.members.empty()) {
      ended_.push_back(it->first);
      streams_.erase(it);
    }
    return;
  }
}

std::vector<ViewerKey> VideoStreams::takers(StreamId id, bool key, TimePoint now) {
  std::vector<ViewerKey> all;
  const auto it = streams_.find(id);
  if (it == streams_.end()) return all;
  if (key) it->second.key_at = now;
  for (auto& [viewer, begun] : it->second.members) {
    begun = begun || key;
    if (begun) all.push_back(viewer);
  }
  return all;
}

std::vector<ViewerKey> VideoStreams::members(StreamId id) const {
  std::vector<ViewerKey> all;
  if (const auto it = streams_.find(id); it != streams_.end())
    for (const auto& [viewer, begun] : it->second.members) all.push_back(viewer);
  return all;
}

}  // namespace isostrata
