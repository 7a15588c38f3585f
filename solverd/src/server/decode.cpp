#include "server/decode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

#include "lattice/refused.h"

namespace lappet {
namespace {

constexpr std::int64_t kMaxInt = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kMaxBytes = std::int64_t{1} << 50;

[[noreturn]] void invalid(const std::string& sentence) { throw RefusedError(ErrorCode::kInvalidInput, sentence); }

int integer_field(FieldReader& reader, std::string_view name, std::int64_t low, std::int64_t high = kMaxInt) {
  return static_cast<int>(reader.integer(name, low, high));
}

Vec3 point_at(const std::vector<double>& elements, std::size_t index) {
  return {elements[3 * index], elements[3 * index + 1], elements[3 * index + 2]};
}

std::vector<Vec3> to_points(const std::vector<double>& elements) {
  std::vector<Vec3> points(elements.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = point_at(elements, i);
  return points;
}

// By rows.
std::vector<Eigen::Matrix4d> to_matrices(const std::vector<double>& elements) {
  std::vector<Eigen::Matrix4d> matrices;
  for (std::size_t i = 0; i + 15 < elements.size(); i += 16)
    matrices.emplace_back(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(&elements[i]));
  return matrices;
}

// Refuses an index outside [low, count).
void check_indices(const std::vector<std::int32_t>& indices, std::string_view array, std::int32_t low,
                   std::int64_t count, std::string_view of) {
  const auto bad = std::ranges::find_if(indices, [&](std::int32_t index) { return index < low || index >= count; });
  if (bad != indices.end()) {
    invalid("The array '" + std::string(array) + "' holds " + std::to_string(*bad) + " at element " +
            std::to_string(bad - indices.begin()) + "; there are " + std::to_string(count) + " " + std::string(of) +
            ".");
  }
}

// Refuses an index that comes twice.
void check_distinct(std::vector<std::int32_t> indices, std::string_view array) {
  std::ranges::sort(indices);
  const auto twice = std::ranges::adjacent_find(indices);
  if (twice != indices.end()) {
    invalid("The array '" + std::string(array) + "' holds " + std::to_string(*twice) + " twice.");
  }
}

std::int32_t checked_count(std::size_t count, std::string_view of) {
  if (count > static_cast<std::size_t>(kMaxInt)) {
    invalid("There are " + std::to_string(count) + " " + std::string(of) + "; at most " + std::to_string(kMaxInt) +
            " can be numbered.");
  }
  return static_cast<std::int32_t>(count);
}

std::int64_t length(std::size_t count) { return static_cast<std::int64_t>(count); }

// Reads settings into a SessionSettings (visit_settings).
class SettingReader {
 public:
  explicit SettingReader(FieldReader& reader) : reader_(&reader) {}

  void operator()(std::string_view name, double& value) const { value = reader_->number(name); }
  void operator()(std::string_view name, std::int32_t& value, std::int32_t low = 0,
                  std::int32_t high = std::numeric_limits<std::int32_t>::max()) const {
    value = integer_field(*reader_, name, low, high);
  }
  void operator()(std::string_view name, std::size_t& value) const {
    value = static_cast<std::size_t>(reader_->integer(name, 0, kMaxBytes));
  }
  void operator()(std::string_view name, bool& value) const { value = integer_field(*reader_, name, 0, 1) == 1; }
  void operator()(std::string_view name, std::string& value) const { value = reader_->text(name); }
  void operator()(std::string_view name, Vec3& value) const {
    const std::array<double, 3> numbers = reader_->vector3(name);
    value = Vec3(numbers[0], numbers[1], numbers[2]);
  }
  template <class T>
  void optional(std::string_view name, T& value) const {
    if (reader_->has(name)) (*this)(name, value);
  }

 private:
  FieldReader* reader_;
};

MaterialParameters decode_material(FieldReader& reader) {
  MaterialParameters material;
  material.model = reader.text("model");
  material.youngs_modulus = reader.number("youngs_modulus");
  material.poissons_ratio = reader.number("poissons_ratio");
  material.density = reader.number("density");
  material.mooney_ratio = reader.number("mooney_ratio", material.mooney_ratio);
  if (reader.has("fiber_direction")) {
    const std::array<double, 3> direction = reader.vector3("fiber_direction");
    material.fiber_direction = Vec3(direction[0], direction[1], direction[2]);
  }
  material.fiber_k1 = reader.number("fiber_k1", material.fiber_k1);
  material.fiber_k2 = reader.number("fiber_k2", material.fiber_k2);
  material.fiber_dispersion = reader.number("fiber_dispersion", material.fiber_dispersion);
  material.fiber_slack = reader.number("fiber_slack", material.fiber_slack);
  material.fiber_angle = reader.number("fiber_angle", material.fiber_angle);
  material.muscle_stress = reader.number("muscle_stress", material.muscle_stress);
  if (reader.has("prestretch")) {
    const std::vector<double> prestretch = reader.numbers("prestretch", 2);
    material.prestretch = {prestretch[0], prestretch[1]};
  }
  return material;
}

// Reads points (n,3) and triangles (m,3) under these names.
Surface decode_surface(ArrayReader& arrays, std::string_view points, std::string_view triangles,
                       const std::string& of) {
  Surface surface;
  surface.points = to_points(arrays.read_coordinates(points, {kAny, 3}));
  const std::int32_t count = checked_count(surface.points.size(), of);
  const std::vector<std::int32_t> corners = arrays.read<std::int32_t>(triangles, {kAny, 3});
  check_indices(corners, triangles, 0, count, of);
  checked_count(corners.size() / 3, "triangles");
  surface.triangles.resize(corners.size() / 3);
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
    surface.triangles[i] = {corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]};
  return surface;
}

void decode_strands(ArrayReader& arrays, std::int32_t materials, EpochInput& epoch) {
  const auto start = arrays.read<std::int32_t>("strand_start", {kAny});
  const auto material = arrays.read<std::int32_t>("strand_material", {length(start.size())});
  check_indices(material, "strand_material", 0, materials, "materials");
  const std::vector<Vec3> points = to_points(arrays.read_coordinates("strand_points", {kAny, 3}));
  const std::vector<double> radii = arrays.read_finite("strand_radii", {length(points.size())});
  for (std::size_t k = 0; k < start.size(); ++k) {
    const auto first = static_cast<std::int64_t>(start[k]);
    const std::int64_t end = k + 1 < start.size() ? start[k + 1] : length(points.size());
    if (first < 0 || first >= end || end > length(points.size()) || (k == 0 && first != 0))
      invalid("The array 'strand_start' must begin with 0 and grow, each below the number of points; element " +
              std::to_string(k) + " is " + std::to_string(first) + ".");
    epoch.strands.push_back(
        {material[k], {points.begin() + first, points.begin() + end}, {radii.begin() + first, radii.begin() + end}});
  }
}

void decode_regions(FieldReader& reader, ArrayReader& arrays, std::int32_t materials, EpochInput& epoch) {
  reader.maps("regions", [&](FieldReader& entry) {
    MaterialRegion region;
    region.material = integer_field(entry, "material", 0, materials - 1);
    region.from_depth = entry.number("depth_from");
    region.to_depth = entry.number("depth_to", region.to_depth);
    epoch.regions.push_back(std::move(region));
  });
  const std::size_t count = epoch.skin.triangles.size();
  const auto faces = arrays.read<std::uint8_t>("region_faces", {length(epoch.regions.size()), length(count)});
  for (std::size_t r = 0; r < epoch.regions.size(); ++r) {
    const auto first = faces.begin() + static_cast<std::ptrdiff_t>(r * count);
    epoch.regions[r].faces.assign(first, first + static_cast<std::ptrdiff_t>(count));
  }
}

// Of `count` triangles.
void decode_loads_and_rollers(ArrayReader& arrays, std::int32_t count, EpochInput& epoch) {
  if (arrays.has("roller_faces")) {
    epoch.roller = arrays.read<std::int32_t>("roller_faces", {count});
    epoch.roller_normals = to_points(arrays.read_finite("roller_normals", {kAny, 3}));
    check_indices(epoch.roller, "roller_faces", -1, length(epoch.roller_normals.size()), "rollers (-1: on none)");
  }
  if (arrays.has("loaded_index")) {
    epoch.loaded_index = arrays.read<std::int32_t>("loaded_index", {kAny});
    check_indices(epoch.loaded_index, "loaded_index", 0, kMaxInt, "numbers");
    check_distinct(epoch.loaded_index, "loaded_index");
    epoch.loaded_faces = arrays.read<std::uint8_t>("loaded_faces", {length(epoch.loaded_index.size()), count});
  }
  if (arrays.has("section_points")) {
    epoch.section_points = to_points(arrays.read_coordinates("section_points", {kAny, 3}));
    epoch.section_normals = to_points(arrays.read_finite("section_normals", {length(epoch.section_points.size()), 3}));
  }
}

std::vector<HookState> decode_hooks(ArrayReader& arrays, const FrameLimits& limits) {
  const std::vector<double> hook_anchors = arrays.read_coordinates("hook_anchors", {kAny, 3});
  const std::size_t hooks = hook_anchors.size() / 3;
  const auto hook_triangles = arrays.read<std::int32_t>("hook_triangles", {length(hooks)});
  check_indices(hook_triangles, "hook_triangles", 0, limits.triangles, "triangles");
  const std::vector<double> hook_targets = arrays.read_coordinates("hook_targets", {length(hooks), 3});
  const std::vector<double> hook_stiffness = arrays.read_finite("hook_stiffness", {length(hooks)});
  std::vector<std::int32_t> index(hooks);
  std::iota(index.begin(), index.end(), 0);
  if (arrays.has("hook_index")) index = arrays.read<std::int32_t>("hook_index", {length(hooks)});
  check_distinct(index, "hook_index");
  std::vector<HookState> result;
  for (std::size_t i = 0; i < hooks; ++i)
    result.push_back(
        {{point_at(hook_anchors, i), hook_triangles[i]}, point_at(hook_targets, i), hook_stiffness[i], index[i]});
  return result;
}

// Those that each suture has between its ends.
std::vector<std::vector<Anchor>> decode_inner_bites(ArrayReader& arrays, std::size_t sutures, std::int32_t triangles) {
  std::vector<std::vector<Anchor>> result(sutures);
  if (!arrays.has("suture_inner_bites")) return result;
  const auto counts = arrays.read<std::int32_t>("suture_inner_bites", {length(sutures)});
  const auto of_bites = arrays.read<std::int32_t>("inner_bite_triangles", {kAny});
  const std::vector<double> anchors = arrays.read_coordinates("inner_bite_anchors", {length(of_bites.size()), 3});
  check_indices(of_bites, "inner_bite_triangles", 0, triangles, "triangles");
  std::size_t next = 0;
  for (std::size_t i = 0; i < sutures; ++i) {
    if (counts[i] < 0 || static_cast<std::size_t>(counts[i]) > of_bites.size() - next)
      invalid("The array 'suture_inner_bites' says " + std::to_string(counts[i]) + " in row " + std::to_string(i) +
              ", where " + std::to_string(of_bites.size() - next) + " of 'inner_bite_triangles' are left.");
    for (std::int32_t k = 0; k < counts[i]; ++k, ++next) result[i].push_back({point_at(anchors, next), of_bites[next]});
  }
  if (next != of_bites.size())
    invalid("The array 'suture_inner_bites' adds up to " + std::to_string(next) + " but there are " +
            std::to_string(of_bites.size()) + " of 'inner_bite_triangles'.");
  return result;
}

std::vector<SutureState> decode_sutures(ArrayReader& arrays, const FrameLimits& limits) {
  const auto suture_index = arrays.read<std::int32_t>("suture_index", {kAny});
  const std::size_t sutures = suture_index.size();
  check_indices(suture_index, "suture_index", 0, limits.sutures, "sutures in the procedure");
  check_distinct(suture_index, "suture_index");
  const std::vector<double> suture_anchors = arrays.read_coordinates("suture_anchors", {length(sutures), 2, 3});
  const auto suture_triangles = arrays.read<std::int32_t>("suture_triangles", {length(sutures), 2});
  check_indices(suture_triangles, "suture_triangles", 0, limits.triangles, "triangles");
  const std::vector<double> closure = arrays.read_finite("suture_closure", {length(sutures)});
  const std::vector<double> suture_stiffness = arrays.read_finite("suture_stiffness", {length(sutures)});
  std::vector<std::uint8_t> is_thread(sutures, 0);
  std::vector<double> lengths(sutures, 0.0), tensions(sutures, 0.0);
  if (arrays.has("suture_is_thread")) {
    is_thread = arrays.read<std::uint8_t>("suture_is_thread", {length(sutures)});
    lengths = arrays.read_coordinates("suture_length", {length(sutures)});
    tensions = arrays.read_finite("suture_tension", {length(sutures)});
  }
  std::vector<std::vector<Anchor>> inner = decode_inner_bites(arrays, sutures, limits.triangles);
  std::vector<SutureState> result;
  for (std::size_t i = 0; i < sutures; ++i) {
    if (closure[i] < 0.0 || closure[i] > 1.0) {
      invalid("The closure of suture " + std::to_string(suture_index[i]) + " is " + std::to_string(closure[i]) +
              "; it must lie between 0 (as placed) and 1 (drawn together).");
    }
    result.push_back({suture_index[i],
                      {point_at(suture_anchors, 2 * i), suture_triangles[2 * i]},
                      {point_at(suture_anchors, 2 * i + 1), suture_triangles[2 * i + 1]},
                      closure[i],
                      suture_stiffness[i],
                      is_thread[i] != 0,
                      lengths[i],
                      tensions[i],
                      std::move(inner[i])});
  }
  return result;
}

std::vector<RetractorState> decode_retractors(ArrayReader& arrays, const FrameLimits& limits) {
  const auto retractor_index = arrays.read<std::int32_t>("retractor_index", {kAny});
  check_indices(retractor_index, "retractor_index", 0, limits.retractors, "retractors in the procedure");
  check_distinct(retractor_index, "retractor_index");
  const std::vector<double> motion =
      arrays.read_coordinates("retractor_motion", {length(retractor_index.size()), 4, 4});
  const std::vector<Eigen::Matrix4d> motions = to_matrices(motion);
  std::vector<RetractorState> result;
  for (std::size_t i = 0; i < retractor_index.size(); ++i) result.push_back({retractor_index[i], motions[i]});
  return result;
}

}  // namespace

Hello decode_hello(const Header& header, ArrayParts parts) {
  ArrayReader(header, parts).finish();
  FieldReader reader(header.fields, header.type);
  Hello hello{reader.has("token") ? reader.text("token") : std::string(), reader.text("client")};
  reader.finish();
  return hello;
}

SessionSettings decode_open(const Header& header, ArrayParts parts) {
  ArrayReader arrays(header, parts);
  FieldReader open(header.fields, header.type);
  SessionSettings settings;
  FieldReader reader(open.map("settings"), "settings");
  visit_settings(settings, SettingReader(reader));
  reader.finish();
  settings.materials.clear();
  open.maps("materials", [&](FieldReader& material) { settings.materials.push_back(decode_material(material)); });
  open.finish();
  if (arrays.has("bone_points") || arrays.has("bone_triangles")) {
    settings.bones.points = to_points(arrays.read_coordinates("bone_points", {kAny, 3}));
    const std::int32_t points = checked_count(settings.bones.points.size(), "points of bones");
    const std::vector<std::int32_t> triangles = arrays.read<std::int32_t>("bone_triangles", {kAny, 3});
    check_indices(triangles, "bone_triangles", 0, points, "points of bones");
    for (std::size_t i = 0; i < triangles.size(); i += 3)
      settings.bones.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    if (arrays.has("bone_bodies"))
      settings.bone_bodies = arrays.read<std::int32_t>("bone_bodies", {length(settings.bones.triangles.size())});
  }
  arrays.finish();
  return settings;
}

EpochInput decode_epoch(const Header& header, ArrayParts parts, std::int32_t retractors, std::int32_t materials) {
  FieldReader reader(header.fields, header.type);
  ArrayReader arrays(header, parts);
  EpochInput epoch;
  epoch.index = integer_field(reader, "index", 0);
  epoch.surface = decode_surface(arrays, "points", "triangles", "surface points");
  const auto count = static_cast<std::int32_t>(epoch.surface.triangles.size());
  if (reader.has("regions") || arrays.has("skin_points") || arrays.has("skin_triangles"))
    epoch.skin = decode_surface(arrays, "skin_points", "skin_triangles", "skin points");
  if (arrays.has("skin_directions"))
    epoch.skin_fields.directions =
        to_points(arrays.read_coordinates("skin_directions", {length(epoch.skin.points.size()), 3}));
  if (arrays.has("skin_stretch")) {
    const std::vector<double> stretch = arrays.read_finite("skin_stretch", {length(epoch.skin.points.size()), 2});
    for (std::size_t i = 0; i < stretch.size(); i += 2)
      epoch.skin_fields.stretch.push_back({stretch[i], stretch[i + 1]});
  }
  if (arrays.has("ground_points") || arrays.has("ground_triangles"))
    epoch.ground = decode_surface(arrays, "ground_points", "ground_triangles", "ground points");
  if (reader.has("regions")) decode_regions(reader, arrays, materials, epoch);
  if (arrays.has("strand_start")) decode_strands(arrays, materials, epoch);
  if (reader.has("rest_nodes")) epoch.nodes = integer_field(reader, "rest_nodes", 0, 1) == 1;
  reader.finish();
  epoch.fixed = arrays.read<std::uint8_t>("fixed", {count});
  if (arrays.has("fixed_parts")) {
    epoch.fixed_parts = arrays.read<std::int32_t>("fixed_parts", {count});
    check_indices(epoch.fixed_parts, "fixed_parts", -1, count, "triangles (-1: not fixed)");
  }
  epoch.bed = arrays.read<std::uint8_t>("support", {count});
  if (arrays.has("walls")) epoch.walls = arrays.read<std::uint8_t>("walls", {count});
  epoch.grip = arrays.read<std::int32_t>("grip", {count});
  check_indices(epoch.grip, "grip", -1, retractors, "retractors (-1: not gripped)");
  decode_loads_and_rollers(arrays, count, epoch);
  epoch.landmarks = to_points(arrays.read_coordinates("landmarks", {kAny, 3}));
  epoch.landmark_triangles = arrays.read<std::int32_t>("landmark_triangles", {length(epoch.landmarks.size())});
  check_indices(epoch.landmark_triangles, "landmark_triangles", 0, count, "triangles");
  arrays.finish();
  return epoch;
}

SolverState decode_state(const Header& header, ArrayParts parts, std::int32_t sutures, std::int32_t materials) {
  FieldReader reader(header.fields, header.type);
  ArrayReader arrays(header, parts);
  SolverState state;
  const std::string precision = reader.text("precision");
  reader.finish();
  if (precision != "float" && precision != "double") {
    invalid("The precision of the state is " + in_quotes(precision) + "; it must be 'float' or 'double'.");
  }
  state.is_double = precision == "double";
  if (state.is_double) {
    state.nodes = arrays.read<double>("nodes", {kAny, 3});
  } else {
    const std::vector<float> nodes = arrays.read<float>("nodes", {kAny, 3});
    state.nodes.assign(nodes.begin(), nodes.end());
  }
  if (!std::ranges::all_of(state.nodes, [](double x) { return std::isfinite(x); })) {
    invalid("The array 'nodes' of the state holds a value that is not finite.");
  }
  check_coordinates(state.nodes, "nodes");
  state.suture_gaps = arrays.read<double>("suture_separations", {sutures, 3});  // NaN: not placed yet
  check_coordinates(state.suture_gaps, "suture_separations");
  state.suture_multipliers = arrays.read_finite("suture_multipliers", {sutures, 3});
  state.grip_multipliers = arrays.read_finite("grip_multipliers", {kAny});
  if (arrays.has("roller_multipliers")) state.roller_multipliers = arrays.read_finite("roller_multipliers", {kAny});
  if (arrays.has("loads")) {
    state.loads = arrays.read_finite("loads", {kAny, 5});
    for (std::size_t k = 0; k < state.loads.size(); k += 5)
      if (!(std::abs(state.loads[k]) < static_cast<double>(kMaxInt)))
        invalid("The array 'loads' of the state names faces by a number that is too large.");
  }
  state.stability = arrays.read_finite("stability", {kAny});
  state.activation = arrays.read_finite("activation", {materials});
  if (arrays.has("bone_motion")) state.bone_motions = arrays.read_finite("bone_motion", {kAny, 4, 4});
  if (arrays.has("motion")) {
    state.motion = arrays.read<float>("motion", {kAny, 3});
    check_coordinates(std::vector<double>(state.motion.begin(), state.motion.end()), "motion");
    if (!std::ranges::all_of(state.motion, [](float x) { return std::isfinite(x); }))
      invalid("The array 'motion' of the state holds a value that is not finite.");
  }
  arrays.finish();
  return state;
}

FrameInput decode_solve(const Header& header, ArrayParts parts, const FrameLimits& limits) {
  FieldReader reader(header.fields, header.type);
  ArrayReader arrays(header, parts);
  FrameInput frame;
  frame.time = reader.number("time");
  reader.finish();
  frame.hooks = decode_hooks(arrays, limits);
  frame.sutures = decode_sutures(arrays, limits);
  frame.retractors = decode_retractors(arrays, limits);
  if (arrays.has("load_index")) {
    const auto index = arrays.read<std::int32_t>("load_index", {kAny});
    check_distinct(index, "load_index");
    const std::vector<Vec3> tractions = to_points(arrays.read_finite("load_traction", {length(index.size()), 3}));
    const std::vector<double> pressures = arrays.read_finite("load_pressure", {length(index.size())});
    for (std::size_t i = 0; i < index.size(); ++i) frame.loads.push_back({index[i], tractions[i], pressures[i]});
  }
  if (arrays.has("activation")) frame.activation = arrays.read_finite("activation", {limits.materials});
  if (arrays.has("bone_motion"))
    frame.bone_motions = to_matrices(arrays.read_finite("bone_motion", {limits.bones, 4, 4}));
  arrays.finish();
  return frame;
}

void decode_bare(const Header& header, ArrayParts parts) {
  FieldReader(header.fields, header.type).finish();
  ArrayReader(header, parts).finish();
}

}  // namespace lappet
