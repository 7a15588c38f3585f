#include "replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>

#include "lattice/refused.h"
#include "lattice/surface_box.h"
#include "server/decode.h"
#include "server/encode.h"
#include "session/checks.h"

namespace lappet {
namespace {

using Views = std::vector<std::span<const std::byte>>;

constexpr std::uint64_t kMaxBytes = 1 << 26;
constexpr std::uint64_t kSession = 1;
// What a message may cost here, whatever it asks for.
constexpr double kSeconds = 0.2;
constexpr std::size_t kMemory = std::size_t{64} << 20;
constexpr int kNewton = 20, kManyNewton = 100'000;
constexpr std::int32_t kConstraints = 1000;

Views views_of(const RawMessage& message) {
  if (message.empty()) return {};
  return {message.begin() + 1, message.end()};
}

void bound(SessionSettings& settings) {
  if (settings.time_budget == 0.0 || settings.time_budget > kSeconds) settings.time_budget = kSeconds;
  settings.memory_budget = std::min(settings.memory_budget, kMemory);
  if (settings.max_newton < kManyNewton) settings.max_newton = std::min(settings.max_newton, kNewton);
  settings.sutures = std::min(settings.sutures, kConstraints);
  settings.retractors = std::min(settings.retractors, kConstraints);
  if (settings.threads == 0 || settings.threads > 1) settings.threads = 1;
}

template <class Real>
void require_finite(const std::vector<Real>& numbers, const char* array) {
  if (!std::ranges::all_of(numbers, [](Real number) { return std::isfinite(number); }))
    throw Finding(std::string("a frame that converged has a number in '") + array + "' that is not finite");
}

void check_output(const FrameOutput& frame) {
  if (!frame.converged) return;
  require_finite(frame.points, "points");
  require_finite(frame.landmarks, "landmarks");
  require_finite(frame.hook_points, "hook_points");
  require_finite(frame.suture_points, "suture_points");
  require_finite(frame.state.nodes, "nodes");
}

// A client reads a reply within the limits that the daemon has itself.
std::vector<PartBytes> readable(std::vector<PartBytes> reply) {
  try {
    const Header header = decode_header(reply.front());
    const Views arrays = views_of(reply);
    ArrayReader(header, arrays);  // one part of the right length for each
    if (header.type == "error" && std::get<std::string>(header.fields.at("code")) == "internal")
      throw Finding("the daemon calls it a fault of its own: " + std::get<std::string>(header.fields.at("message")));
  } catch (const RefusedError& error) {
    throw Finding(std::string("the reply cannot be read: ") + error.what());
  }
  return reply;
}

// What `body` returns, or the error that the daemon answers with.
template <class Body>
std::vector<PartBytes> replied(const RawMessage& message, const Body& body) {
  const std::uint64_t id = message.empty() ? 0 : guess_id(message.front());
  try {
    return readable(body());
  } catch (const RefusedError& error) {
    return readable(encode_error({id, kSession}, error.code(), error.what()));
  } catch (const std::bad_alloc&) {
    return readable(encode_error({id, kSession}, ErrorCode::kMemoryBudget, "The machine's memory is spent."));
  } catch (const Finding&) {
    throw;
  } catch (const std::exception& error) {
    throw Finding(std::string("an exception that the daemon does not know: ") + error.what());
  }
}

[[noreturn]] void out_of_order(const std::string& sentence) { throw RefusedError(ErrorCode::kOutOfOrder, sentence); }

// As `Server::receive` and `Server::handle` read it.
Header header_of(const RawMessage& message) {
  if (message.empty()) malformed("The message has no header part.");
  if (message.size() > kMaxArrays + 1) malformed("The message has too many array parts.");
  return decode_header(message.front(), kMaxBytes);
}

}  // namespace

std::vector<PartBytes> Replay::play(const RawMessage& message) {
  return replied(message, [&] { return answer(message); });
}

std::vector<PartBytes> Replay::answer(const RawMessage& message) {
  static constexpr std::array<std::string_view, 5> kBare = {"ping", "cancel", "close", "bye", "shutdown"};
  const Header header = header_of(message);
  const Views arrays = views_of(message);
  if (std::ranges::find(kBare, header.type) != kBare.end()) return answer_bare(header, arrays);
  if (header.type == "hello") {
    decode_hello(header, arrays);
    return encode_welcome({header.id, 0}, 1, kMaxBytes);
  }
  if (header.type != "open") return work(header, arrays);
  SessionSettings settings = decode_open(header, arrays);
  if (session_) out_of_order("A session is open.");
  bound(settings);
  session_ = std::make_unique<Session>(settings);
  settings_ = settings;
  epoch_triangles_.reset();
  return encode_opened({header.id, kSession});
}

std::vector<PartBytes> Replay::answer_bare(const Header& header, std::span<const std::span<const std::byte>> arrays) {
  decode_bare(header, arrays);
  if (header.type == "ping") return encode_pong({header.id, 0});
  if (header.type != "cancel") session_.reset();
  return encode_accepted({header.id, kSession});
}

std::vector<PartBytes> Replay::work(const Header& header, std::span<const std::span<const std::byte>> arrays) {
  if (header.type != "epoch" && header.type != "state" && header.type != "solve")
    malformed("The message type " + in_quotes(header.type) + " is not known.");
  if (!session_) out_of_order("There is no session.");
  if (header.session && *header.session != kSession) out_of_order("The session is not open.");
  const ReplyTo to{header.id, kSession};
  const auto materials = static_cast<std::int32_t>(settings_.materials.size());
  if (header.type == "epoch") {
    const EpochInput epoch = decode_epoch(header, arrays, settings_.retractors, materials);
    const EpochReport report = session_->set_epoch(epoch);
    epoch_triangles_ = static_cast<std::int32_t>(epoch.surface.triangles.size());
    return encode_lattice(to, report);
  }
  if (!epoch_triangles_) out_of_order("There is no epoch.");
  if (header.type == "state") {
    session_->set_state(decode_state(header, arrays, settings_.sutures, materials));
    return encode_accepted(to);
  }
  const FrameInput frame =
      decode_solve(header, arrays,
                   {*epoch_triangles_, settings_.sutures, settings_.retractors, materials, settings_.moving_bones()});
  const auto report = [&](const Progress& progress) { readable(encode_progress(to, progress)); };
  const FrameOutput output = session_->solve(frame, report, kNotCancelled);
  check_output(output);
  return encode_frame(to, output);
}

void decode_alone(const RawMessage& message) {
  constexpr std::int32_t kMany = 4;
  replied(message, [&] {
    const Header header = header_of(message);
    const Views arrays = views_of(message);
    SessionSettings session;
    session.sutures = session.retractors = kMany;
    session.materials.resize(2);
    if (header.type == "hello") decode_hello(header, arrays);
    if (header.type == "open") check_settings(decode_open(header, arrays));
    if (header.type == "epoch") check_epoch(decode_epoch(header, arrays, kMany, 2), session);
    if (header.type == "state") decode_state(header, arrays, 2, 1);
    if (header.type == "solve") {
      const FrameInput frame = decode_solve(header, arrays, {12, kMany, kMany, 2});
      Surface surface;
      surface.points = {Vec3::Zero(), Vec3(4.0, 4.0, 2.0)};
      surface.triangles.resize(12, {0, 1, 0});
      check_frame(frame, session, surface, box_around(surface));
    }
    return encode_accepted({header.id, kSession});
  });
}

}  // namespace lappet
