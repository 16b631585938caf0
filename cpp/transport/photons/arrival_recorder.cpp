// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photons/arrival_recorder.h"

namespace sluice {

ArrivalRecorder::Word ArrivalRecorder::add(const Step& step) noexcept {
  if (event_count_ == static_cast<int>(events_.size())) return step.before;
  events_[static_cast<std::size_t>(event_count_)] = step;
  return {event_count_++};
}

ArrivalRecorder::Word ArrivalRecorder::started(int light) noexcept {
  return add({{}, Event::L, scene_.light_entity(light)});
}

ArrivalRecorder::Word ArrivalRecorder::scattered(const Word& word, Event event, const Hit& hit) noexcept {
  return add({word, event, scene_.entity(hit)});
}

ArrivalRecorder::Word ArrivalRecorder::moved(const Word& word, int edit) noexcept {
  return add({word, Event::F, edit});
}

void ArrivalRecorder::crossed(const Path& path, const Segment& segment,
                              const std::optional<Crossing>& capture) noexcept {
  if (segment.excluded_group == entry().group) return;
  const auto hit = intersect(entry(), segment.origin, segment.direction);
  if (!hit || hit->t <= segment.t_min || hit->t > segment.t_max) return;
  const bool is_taken =
      capture && (capture->group == entry().group ? is_first(*capture) : capture->t < hit->t);
  note(path, segment.direction, is_taken ? capture : std::nullopt);
}

void ArrivalRecorder::left_exit(const Path& path, const std::optional<Crossing>& capture) noexcept {
  if (path.at_edit == edit_ || scene_.edits().quad(path.at_edit, path.at_exit).group != entry().group ||
      !locate(entry(), path.origin))
    return;
  const bool is_taken = capture && is_first(*capture);
  note(path, V3d(path.direction), is_taken ? capture : std::nullopt);
}

bool ArrivalRecorder::is_first(const Crossing& capture) const noexcept {
  return std::pair(capture.order, capture.edit) < std::pair(scene_.edits()[edit_].order, edit_);
}

void ArrivalRecorder::note(const Path& path, const V3d& direction,
                           const std::optional<Crossing>& taken_before) noexcept {
  if (path.word.last < 0 || crossing_count_ == static_cast<int>(crossings_.size())) return;
  if (taken_before)
    taker_ = taken_before->edit;
  else
    crossings_[static_cast<std::size_t>(crossing_count_++)] = {path.word, luminance(path.flux),
                                                               direction.dot(entry().frame.n) > 0};
}

}  // namespace sluice
