// What a frame says of the tissue where its search ended.
#pragma once
#include "session/find_frame.h"

namespace lappet {

// Results of hooks and sutures stand in the order of the frame's hooks and sutures, whose ids they carry.
template <class Real>
FrameFields frame_fields(const SessionSettings& settings, EpochSystem<Real>& epoch, const FrameInput& frame,
                         const FoundFrame<Real>& found);

}  // namespace lappet
