// What the engine is asked for one viewer alone: pictures to keep, which are not shown, so that neither credits nor the ladder have to do
// with them, histograms, and what lies at a place, along a line and over the steps.
#pragma once

#include <map>
#include <set>
#include <utility>

#include "session/datasets/engine_door.h"
#include "session/people/participants.h"

namespace isostrata {

/// Of one session. Not thread-safe: lives on the io thread.
class ViewerAnswers {
 public:
  static constexpr std::size_t kMostPictures = 2;  // of one viewer at once
  static constexpr int kMostHistograms = 16;       // of all together

  /// Both must outlive it, and it the answers.
  ViewerAnswers(SessionKey session, EngineDoor& engine, const Participants& people) : session_(session), engine_(engine), people_(people) {}

  /// Answers the message `seq` by a Frame that says so, or an Error. Without a size the picture is as large as the viewport.
  void draw(Viewer& viewer, const v1::RequestStill& wanted, std::uint64_t seq);
  /// Answers by a Histogram or an Error.
  void count(Viewer& viewer, HistogramRequest request, std::uint64_t seq);
  /// Answers by a ProbeResult or an Error. One that the viewer asked before and that is not answered yet is given up, and answered so.
  void probe(Viewer& viewer, ProbeRequest request, std::uint64_t seq);
  /// The same by a ProbedCurve; of lines and of places over steps each by itself.
  void probe(Viewer& viewer, CurveRequest request, std::uint64_t seq);
  /// The same by a LayerStatistics.
  void measure(Viewer& viewer, LayerStatisticsRequest request, std::uint64_t seq);
  /// The place over steps that is not answered yet.
  void give_up_steps(ViewerKey viewer);
  /// The viewer is gone.
  void leave(ViewerKey viewer);

 private:
  enum class Asked { place, line, steps, statistics };
  using ProbeKey = std::pair<ViewerKey, Asked>;
  template <class Ready, class Request, class Answer>
  void probe(Viewer& viewer, Asked asked, Request request, std::uint64_t seq, const Answer& answer);
  void give_up_probe(ProbeKey probe);
  void drawn(ViewerKey viewer, RequestId request, std::uint64_t seq, const EngineEvent& event);

  const SessionKey session_;
  EngineDoor& engine_;
  const Participants& people_;
  std::map<ViewerKey, std::set<RequestId>> pictures_;  // that are being drawn
  struct Probe {
    RequestId request = 0;
    std::uint64_t seq = 0;
  };
  std::map<ProbeKey, Probe> probes_;                   // that are being looked up
  int histograms_ = 0;                                 // that are being counted
};

}  // namespace isostrata
