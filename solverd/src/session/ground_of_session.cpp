#include "session/ground_of_session.h"

#include <algorithm>

#include "force/constraints/attachments.h"

namespace lappet {

namespace {

// The faces of an epoch's own surface that the bed holds or bears.
Surface supported_faces(const EpochInput& epoch) {
  Surface sheet{epoch.surface.points, {}};
  for (std::size_t t = 0; t < epoch.bed.size(); ++t)
    if (epoch.bed[t] != 0) sheet.triangles.push_back(epoch.surface.triangles[t]);
  return sheet;
}

}  // namespace

std::shared_ptr<const Ground> GroundOfSession::of(const EpochInput& epoch, const SessionSettings& settings,
                                                  const Interrupt& interrupt) {
  if (std::ranges::find(epoch.bed, kRestsOnBed) == epoch.bed.end()) return nullptr;
  Surface sheet = epoch.ground.triangles.empty() ? supported_faces(epoch) : epoch.ground;
  if (!ground_ || sheet.points != sheet_.points || sheet.triangles != sheet_.triangles) {
    ground_ = std::make_shared<const Ground>(sheet, settings.spacing, settings.memory_budget, interrupt);
    sheet_ = std::move(sheet);
  }
  return ground_;
}

}  // namespace lappet
