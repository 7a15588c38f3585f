// The ground that an epoch's undermined faces rest on, kept while the epochs after it lie on the same.
#pragma once
#include <memory>

#include "force/constraints/ground.h"
#include "session/program.h"

namespace lappet {

class GroundOfSession {
 public:
  // Null where nothing rests. Throws RefusedError where its field needs more memory than the budget.
  std::shared_ptr<const Ground> of(const EpochInput& epoch, const SessionSettings& settings,
                                   const Interrupt& interrupt);

 private:
  Surface sheet_;
  std::shared_ptr<const Ground> ground_;  // of the sheet
};

}  // namespace lappet
