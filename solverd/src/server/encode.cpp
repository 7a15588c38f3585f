#include "server/encode.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "math/instruction_set.h"
#include "server/version.h"

namespace lappet {
namespace {

// A sentence that fits the limit of a text, cut between two characters of UTF-8.
std::string sentence_of(const std::string& text) {
  std::size_t end = std::min(text.size(), kMaxTextBytes);
  while (end > 0 && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0U) == 0x80U) --end;
  return text.substr(0, end);
}

MessageWriter reply(std::string type, ReplyTo to) {
  return {std::move(type), to.id, to.session == 0 ? std::nullopt : std::optional(to.session)};
}

std::string_view restart_name(Restart restart) {
  switch (restart) {
    case Restart::kInvalidStart:
      return "invalid_start";
    case Restart::kNoEquilibrium:
      return "no_equilibrium";
    case Restart::kInverted:
      return "inverted";
    case Restart::kNone:
      break;
  }
  return "";
}

template <class T>
void add_rows(MessageWriter& writer, const std::string& name, const std::vector<T>& elements,
              std::vector<std::uint64_t> row_shape) {
  std::uint64_t row = 1;
  for (const std::uint64_t extent : row_shape) row *= extent;
  std::vector<std::uint64_t> shape = {elements.size() / row};
  shape.insert(shape.end(), row_shape.begin(), row_shape.end());
  writer.array(name, std::span<const T>(elements), std::move(shape));
}

void add_state(MessageWriter& writer, const SolverState& state) {
  if (state.is_double) {
    add_rows(writer, "nodes", state.nodes, {3});
  } else {
    add_rows(writer, "nodes", std::vector<float>(state.nodes.begin(), state.nodes.end()), {3});
  }
  add_rows(writer, "suture_separations", state.suture_gaps, {3});
  add_rows(writer, "suture_multipliers", state.suture_multipliers, {3});
  add_rows(writer, "grip_multipliers", state.grip_multipliers, {});
  if (!state.roller_multipliers.empty()) add_rows(writer, "roller_multipliers", state.roller_multipliers, {});
  if (!state.loads.empty()) add_rows(writer, "loads", state.loads, {5});
  add_rows(writer, "activation", state.activation, {});
  if (!state.bone_motions.empty()) add_rows(writer, "bone_motion", state.bone_motions, {4, 4});
  add_rows(writer, "stability", state.stability, {});
  if (!state.motion.empty()) add_rows(writer, "motion", state.motion, {3});
}

// What a frame says of the tissue.
void add_fields(MessageWriter& writer, const FrameFields& frame) {
  add_rows(writer, "points", frame.points, {3});
  add_rows(writer, "strain", frame.strain, {});
  add_rows(writer, "stress", frame.stress, {});
  add_rows(writer, "tension", frame.tension, {});
  add_rows(writer, "landmarks", frame.landmarks, {3});
  add_rows(writer, "suture_index", frame.suture_indices, {});
  add_rows(writer, "suture_gaps", frame.suture_gaps, {});
  add_rows(writer, "suture_forces", frame.suture_forces, {});
  add_rows(writer, "suture_force_vectors", frame.suture_force_vectors, {3});
  add_rows(writer, "suture_points", frame.suture_points, {2, 3});
  add_rows(writer, "suture_shared", frame.suture_shared, {});
  if (!frame.inner_bite_points.empty()) add_rows(writer, "inner_bite_points", frame.inner_bite_points, {3});
  add_rows(writer, "hook_index", frame.hook_indices, {});
  add_rows(writer, "hook_forces", frame.hook_forces, {3});
  add_rows(writer, "hook_points", frame.hook_points, {3});
  add_rows(writer, "holders", frame.holders, {2});
  add_rows(writer, "reactions", frame.reactions, {3});
  if (!frame.section_forces.empty()) add_rows(writer, "section_forces", frame.section_forces, {3});
  add_rows(writer, "correction", frame.correction, {3});
  add_rows(writer, "landmark_correction", frame.landmark_correction, {3});
  add_rows(writer, "softest_point", frame.softest_point, {3});
}

}  // namespace

std::vector<PartBytes> encode_welcome(ReplyTo to, int threads, std::uint64_t max_message_bytes) {
  return reply("welcome", to)
      .field("version", std::string(kVersion))
      .field("threads", std::int64_t{threads})
      .field("isa", std::string(name(choose_instruction_set())))
      .field("compiler", std::string(kCompiler))
      .field("max_message_bytes", max_message_bytes)
      .finish();
}

std::vector<PartBytes> encode_opened(ReplyTo to) { return reply("opened", to).finish(); }
std::vector<PartBytes> encode_accepted(ReplyTo to) { return reply("accepted", to).finish(); }
std::vector<PartBytes> encode_pong(ReplyTo to) { return reply("pong", to).finish(); }

std::vector<PartBytes> encode_lattice(ReplyTo to, const EpochReport& report) {
  MessageWriter writer = reply("lattice", to);
  writer.field("fine_voxels", report.fine_voxels)
      .field("cells", std::int64_t{report.cells})
      .field("grid_cells", std::int64_t{report.grid_cells})
      .field("mesh_cells", std::int64_t{report.mesh_cells})
      .field("nodes", std::int64_t{report.nodes})
      .field("fragments", std::int64_t{report.fragments})
      .field("blocks", std::int64_t{report.blocks})
      .field("fixed_nodes", std::int64_t{report.fixed_nodes})
      .field("dropped_voxels", report.dropped_voxels)
      .field("volume", report.volume)
      .field("bytes", report.bytes)
      .field("seconds", report.seconds);
  if (!report.nodes_at_rest.empty()) add_rows(writer, "rest_nodes", report.nodes_at_rest, {3});
  return writer.finish();
}

std::vector<PartBytes> encode_progress(ReplyTo to, const Progress& progress) {
  return reply("progress", to)
      .field("time", progress.time)
      .field("newton", std::int64_t{progress.newton_iteration})
      .field("residual", progress.residual)
      .field("gap", progress.gap)
      .finish();
}

std::vector<PartBytes> encode_frame(ReplyTo to, const FrameOutput& frame) {
  MessageWriter writer = reply("frame", to);
  writer.field("time", frame.time)
      .field("converged", frame.converged)
      .field("reason", sentence_of(frame.failure.message))
      .field("reason_code", std::string(frame.failure.name()))
      .field("newton", std::int64_t{frame.newton_iterations})
      .field("pcg", std::int64_t{frame.pcg_iterations})
      .field("load_steps", std::int64_t{frame.load_steps})
      .field("active_cells", frame.active_cells)
      .field("restart", std::string(restart_name(frame.restart)))
      .field("residual", frame.residual)
      .field("force_scale", frame.force_scale)
      .field("displacement_to_come", frame.displacement_to_come)
      .field("largest_gap", frame.largest_gap)
      .field("minimum_j", frame.minimum_j)
      .field("inverted_cells", std::int64_t{frame.inverted_cells})
      .field("energy", frame.energy)
      .field("largest_penetration", frame.largest_penetration)
      .field("contacts", std::int64_t{frame.contacts})
      .field("self_contacts", std::int64_t{frame.self_contacts})
      .field("piercings", std::int64_t{frame.piercings})
      .field("piercings_before", std::int64_t{frame.piercings_before})
      .field("untangled", std::int64_t{frame.untangled})
      .field("lowest_stiffness", frame.lowest_stiffness)
      .field("saddles_left", std::int64_t{frame.saddles_left})
      .field("seconds", Fields{{"update", frame.seconds_update},
                               {"linear", frame.seconds_linear},
                               {"setup", frame.seconds_setup},
                               {"stability", frame.seconds_stability},
                               {"total", frame.seconds_total}})
      .field("work", Fields{{"evaluations", frame.work.evaluations.count},
                            {"evaluation_seconds", frame.work.evaluations.seconds},
                            {"linearizations", frame.work.linearizations.count},
                            {"linearization_seconds", frame.work.linearizations.seconds},
                            {"products", frame.work.products.count},
                            {"product_seconds", frame.work.products.seconds}})
      .field("peak_bytes", frame.peak_bytes)
      .field("precision", std::string(frame.state.is_double ? "double" : "float"));
  add_fields(writer, frame);
  add_state(writer, frame.state);
  return writer.finish();
}

std::vector<PartBytes> encode_error(ReplyTo to, ErrorCode code, const std::string& sentence) {
  return reply("error", to)
      .field("code", std::string(error_name(code)))
      .field("message", sentence_of(sentence))
      .finish();
}

std::string_view error_name(ErrorCode code) {
  switch (code) {
    case ErrorCode::kMalformed:
      return "malformed";
    case ErrorCode::kOutOfOrder:
      return "out_of_order";
    case ErrorCode::kUnauthorized:
      return "unauthorized";
    case ErrorCode::kInvalidInput:
      return "invalid_input";
    case ErrorCode::kMemoryBudget:
      return "memory_budget";
    case ErrorCode::kTimeBudget:
      return "time_budget";
    case ErrorCode::kCancelled:
      return "cancelled";
    case ErrorCode::kInternal:
      break;
  }
  return "internal";
}

}  // namespace lappet
