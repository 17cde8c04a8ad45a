// What callers were compiled with must not change in silence: raise the library's version with any line here.
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <string>
#include <type_traits>

#include "api/palpate.h"
#include "api/palpate_device.h"

namespace {

struct Field {
  const char* name;
  std::size_t offset, expected;
};

#define FIELD(type, member, expected) \
  Field { #type "." #member, offsetof(type, member), expected }

}  // namespace

TEST_CASE("The version is that of this layout and of consumer/exports.txt", "[abi]") {
  CHECK(std::string(palpate_version()) == "0.2.0");
}

TEST_CASE("The structs of palpate.h have the layout that callers were compiled with", "[abi]") {
  CHECK(sizeof(palpate_error) == 1024);
  CHECK(sizeof(palpate_options) == 56);
  CHECK(sizeof(palpate_model_info) == 112);
  CHECK(sizeof(palpate_state) == 248);
  CHECK(sizeof(palpate_parameter) == 24);
  CHECK(sizeof(palpate_tool_state) == 144);
  CHECK(sizeof(palpate_skin_point) == 88);
  CHECK(sizeof(palpate_quantity) == 48);
  CHECK(sizeof(palpate_material_number) == 16);
  CHECK(sizeof(palpate_device_settings) == 64);
  CHECK(sizeof(palpate_device_pose) == 104);
  CHECK(sizeof(palpate_wrench) == 64);
  CHECK(sizeof(palpate_coupling_state) == 96);
  for (const Field& field : std::array{FIELD(palpate_error, size, 0),
                                       FIELD(palpate_error, code, 4),
                                       FIELD(palpate_error, text, 8),
                                       FIELD(palpate_options, size, 0),
                                       FIELD(palpate_options, threads, 4),
                                       FIELD(palpate_options, rate_hz, 8),
                                       FIELD(palpate_options, cache_folder, 16),
                                       FIELD(palpate_options, progress, 24),
                                       FIELD(palpate_options, user, 32),
                                       FIELD(palpate_options, set, 40),
                                       FIELD(palpate_options, set_count, 48),
                                       FIELD(palpate_model_info, size, 0),
                                       FIELD(palpate_model_info, node_count, 4),
                                       FIELD(palpate_model_info, point_count, 8),
                                       FIELD(palpate_model_info, skin_vertex_count, 12),
                                       FIELD(palpate_model_info, skin_triangle_count, 16),
                                       FIELD(palpate_model_info, material_count, 20),
                                       FIELD(palpate_model_info, rate_hz, 24),
                                       FIELD(palpate_model_info, tool_start, 32),
                                       FIELD(palpate_model_info, tool_radius, 88),
                                       FIELD(palpate_model_info, first_contact_travel, 96),
                                       FIELD(palpate_model_info, hash, 104),
                                       FIELD(palpate_state, size, 0),
                                       FIELD(palpate_state, doubt, 4),
                                       FIELD(palpate_state, fresh, 8),
                                       FIELD(palpate_state, frozen, 12),
                                       FIELD(palpate_state, contact_count, 16),
                                       FIELD(palpate_state, loss_count, 20),
                                       FIELD(palpate_state, tick, 24),
                                       FIELD(palpate_state, pose_sequence, 32),
                                       FIELD(palpate_state, time_s, 40),
                                       FIELD(palpate_state, age_s, 48),
                                       FIELD(palpate_state, pose, 56),
                                       FIELD(palpate_state, force, 112),
                                       FIELD(palpate_state, force_filtered, 136),
                                       FIELD(palpate_state, torque, 160),
                                       FIELD(palpate_state, normal, 184),
                                       FIELD(palpate_state, stiffness, 208),
                                       FIELD(palpate_state, depth_m, 216),
                                       FIELD(palpate_state, advance_m, 224),
                                       FIELD(palpate_state, work_J, 232),
                                       FIELD(palpate_state, expected_error, 240),
                                       FIELD(palpate_tool_state, size, 0),
                                       FIELD(palpate_tool_state, contact_count, 4),
                                       FIELD(palpate_tool_state, tick, 8),
                                       FIELD(palpate_tool_state, pose, 16),
                                       FIELD(palpate_tool_state, force, 72),
                                       FIELD(palpate_tool_state, torque, 96),
                                       FIELD(palpate_tool_state, opening, 120),
                                       FIELD(palpate_tool_state, pinch, 128),
                                       FIELD(palpate_tool_state, expected_error, 136),
                                       FIELD(palpate_skin_point, size, 0),
                                       FIELD(palpate_skin_point, triangle, 4),
                                       FIELD(palpate_skin_point, distance, 8),
                                       FIELD(palpate_skin_point, point, 16),
                                       FIELD(palpate_skin_point, normal, 40),
                                       FIELD(palpate_skin_point, barycentric, 64),
                                       FIELD(palpate_device_settings, size, 0),
                                       FIELD(palpate_device_settings, locked, 4),
                                       FIELD(palpate_device_settings, stiffness, 8),
                                       FIELD(palpate_device_settings, damping, 16),
                                       FIELD(palpate_device_settings, max_force, 24),
                                       FIELD(palpate_device_settings, rise_time, 32),
                                       FIELD(palpate_device_settings, scale, 40),
                                       FIELD(palpate_device_settings, own_damping, 48),
                                       FIELD(palpate_device_settings, lever, 56),
                                       FIELD(palpate_device_pose, size, 0),
                                       FIELD(palpate_device_pose, sequence, 4),
                                       FIELD(palpate_device_pose, felt, 8),
                                       FIELD(palpate_device_pose, has_velocity, 12),
                                       FIELD(palpate_device_pose, sent_ns, 16),
                                       FIELD(palpate_device_pose, pose, 24),
                                       FIELD(palpate_device_pose, velocity, 80),
                                       FIELD(palpate_wrench, size, 0),
                                       FIELD(palpate_wrench, touching, 4),
                                       FIELD(palpate_wrench, sequence, 8),
                                       FIELD(palpate_wrench, answers, 12),
                                       FIELD(palpate_wrench, force, 16),
                                       FIELD(palpate_wrench, torque, 40),
                                       FIELD(palpate_coupling_state, size, 0),
                                       FIELD(palpate_coupling_state, engaged, 4),
                                       FIELD(palpate_coupling_state, poses, 8),
                                       FIELD(palpate_coupling_state, silences, 16),
                                       FIELD(palpate_coupling_state, fades, 24),
                                       FIELD(palpate_coupling_state, stiffness, 32),
                                       FIELD(palpate_coupling_state, delay_s, 40),
                                       FIELD(palpate_coupling_state, energy_J, 48),
                                       FIELD(palpate_coupling_state, lowest_energy_J, 56),
                                       FIELD(palpate_coupling_state, damped_J, 64),
                                       FIELD(palpate_coupling_state, peak_force, 72),
                                       FIELD(palpate_coupling_state, peak_torque, 80),
                                       FIELD(palpate_coupling_state, slipped_m, 88),
                                       FIELD(palpate_parameter, name, 0),
                                       FIELD(palpate_parameter, values, 8),
                                       FIELD(palpate_parameter, count, 16)}) {
    INFO(field.name);
    CHECK(field.offset == field.expected);
  }
}

TEST_CASE("The numbers of palpate.h are those that callers were compiled with", "[abi]") {
  const std::array outcomes{PALPATE_OK,      PALPATE_BAD_ARGUMENT, PALPATE_BAD_INPUT,
                            PALPATE_REFUSED, PALPATE_BUSY,         PALPATE_FAILED};
  for (std::size_t k = 0; k < outcomes.size(); ++k) CHECK(outcomes[k] == static_cast<int>(k));
  const std::array doubts{PALPATE_DOUBT_NONE,     PALPATE_DOUBT_VOLUME, PALPATE_DOUBT_CONTACT,
                          PALPATE_DOUBT_SQUEEZED, PALPATE_DOUBT_STEP,   PALPATE_DOUBT_ENERGY,
                          PALPATE_DOUBT_INVERTED, PALPATE_DOUBT_LOST,   PALPATE_DOUBT_RESOLUTION};
  for (std::size_t k = 0; k < doubts.size(); ++k) CHECK(doubts[k] == static_cast<int>(k));
  CHECK(PALPATE_ORDINARY_THREAD == 1);
  for (const auto& [number, expected] :
       {std::pair{int{PALPATE_MATERIAL}, 0}, std::pair{int{PALPATE_TOOL}, 1}, std::pair{int{PALPATE_REGION}, 2},
        std::pair{int{PALPATE_RIGID}, 3}, std::pair{int{PALPATE_NODES}, 0},
        std::pair{int{PALPATE_INTEGRATION_POINTS}, 1}})
    CHECK(number == expected);
}

// The functions' types; their names are held by tests/consumer.
template <class Function, class Expected>
constexpr bool same = std::is_same_v<Function, Expected>;
using Simulation = palpate_simulation*;
using Error = palpate_error*;
static_assert(same<decltype(palpate_load), int32_t(const char*, const palpate_options*, palpate_model**, Error)>);
static_assert(same<decltype(palpate_model_destroy), void(palpate_model*)>);
static_assert(same<decltype(palpate_describe), int32_t(const palpate_model*, palpate_model_info*)>);
static_assert(same<decltype(palpate_skin_triangles), int32_t(const palpate_model*, int32_t*, int32_t)>);
static_assert(
    same<decltype(palpate_script), int32_t(const palpate_model*, const char*, double*, int64_t, int64_t*, Error)>);
static_assert(same<decltype(palpate_script_openings),
                   int32_t(const palpate_model*, const char*, double*, int64_t, int64_t*, Error)>);
static_assert(same<decltype(palpate_create), int32_t(const palpate_model*, Simulation*, Error)>);
static_assert(same<decltype(palpate_destroy), void(Simulation)>);
static_assert(same<decltype(palpate_step), int32_t(Simulation, int64_t, const double*, palpate_state*)>);
static_assert(same<decltype(palpate_start), int32_t(Simulation, uint32_t)>);
static_assert(same<decltype(palpate_last_error), const char*()>);
static_assert(same<decltype(palpate_stop), int32_t(Simulation)>);
static_assert(same<decltype(palpate_set_target), int32_t(Simulation, const double*, uint64_t)>);
static_assert(same<decltype(palpate_read), int32_t(const palpate_simulation*, palpate_state*)>);
static_assert(same<decltype(palpate_skin_positions), int32_t(Simulation, float*, int32_t)>);
static_assert(same<decltype(palpate_contacts), int32_t(Simulation, int32_t*, float*, int32_t, int32_t*)>);
static_assert(same<decltype(palpate_set_tool_friction), int32_t(Simulation, int32_t, double)>);
static_assert(same<decltype(palpate_set_friction), int32_t(Simulation, double)>);
static_assert(
    same<decltype(palpate_set_material), int32_t(Simulation, int32_t, const palpate_parameter*, int32_t, Error)>);
static_assert(same<decltype(palpate_material_parameter),
                   int32_t(const palpate_simulation*, int32_t, int32_t, palpate_parameter*)>);
static_assert(same<decltype(palpate_reset), int32_t(Simulation)>);
static_assert(same<decltype(palpate_save_size), size_t(const palpate_simulation*)>);
static_assert(same<decltype(palpate_save), int32_t(const palpate_simulation*, void*, size_t)>);
static_assert(same<decltype(palpate_restore), int32_t(Simulation, const void*, size_t, Error)>);
static_assert(same<decltype(palpate_tool_count), int32_t(const palpate_model*, int32_t*)>);
static_assert(same<decltype(palpate_set_tool_target), int32_t(Simulation, int32_t, const double*, uint64_t)>);
static_assert(same<decltype(palpate_set_opening), int32_t(Simulation, int32_t, double)>);
static_assert(same<decltype(palpate_read_tool), int32_t(const palpate_simulation*, int32_t, palpate_tool_state*)>);
static_assert(same<decltype(palpate_hash), int32_t(const palpate_simulation*, uint64_t*)>);
using Model = const palpate_model*;
using Team = palpate_team*;
using Points = const palpate_points*;
using Asked = const palpate_simulation*;
static_assert(same<decltype(palpate_load_text),
                   int32_t(const char*, const char*, const char*, const palpate_options*, palpate_model**, Error)>);
static_assert(same<decltype(palpate_count), int32_t(Model, int32_t, int32_t*)>);
static_assert(same<decltype(palpate_name), const char*(Model, int32_t, int32_t)>);
static_assert(same<decltype(palpate_index), int32_t(Model, int32_t, const char*)>);
static_assert(same<decltype(palpate_team_create), int32_t(int32_t, Team*, Error)>);
static_assert(same<decltype(palpate_team_destroy), void(Team)>);
static_assert(same<decltype(palpate_step_many),
                   int32_t(Team, Simulation const*, int32_t, int64_t, const double*, palpate_state*, Error)>);
static_assert(same<decltype(palpate_closest), int32_t(Simulation, const double*, palpate_skin_point*)>);
static_assert(same<decltype(palpate_ray), int32_t(Simulation, const double*, const double*, palpate_skin_point*)>);
static_assert(
    same<decltype(palpate_contact_points), int32_t(Asked, double*, double*, double*, int32_t*, int32_t, int32_t*)>);
static_assert(same<decltype(palpate_reactions), int32_t(Asked, double*, double*, int32_t)>);
static_assert(same<decltype(palpate_pin_force), int32_t(Asked, int32_t, double*)>);
static_assert(same<decltype(palpate_rigid_forces), int32_t(Simulation, double*, int32_t)>);
static_assert(same<decltype(palpate_points_create), int32_t(Model, const double*, int32_t, palpate_points**, Error)>);
static_assert(same<decltype(palpate_points_of), int32_t(Model, int32_t, palpate_points**, Error)>);
static_assert(same<decltype(palpate_points_destroy), void(palpate_points*)>);
static_assert(same<decltype(palpate_points_rest), int32_t(Points, double*, double*, int32_t)>);
static_assert(same<decltype(palpate_displacements), int32_t(Simulation, Points, double*, int32_t)>);
static_assert(same<decltype(palpate_velocities), int32_t(Asked, Points, double*, int32_t)>);
static_assert(same<decltype(palpate_stresses), int32_t(Asked, Points, double*, double*, int32_t)>);
static_assert(same<decltype(palpate_scene_device), int32_t(Model, palpate_device_settings*)>);
static_assert(same<decltype(palpate_couple), int32_t(Simulation, const palpate_device_settings*, Error)>);
static_assert(same<decltype(palpate_uncouple), int32_t(Simulation)>);
static_assert(
    same<decltype(palpate_exchange), int32_t(Simulation, int64_t, const palpate_device_pose*, palpate_wrench*)>);
static_assert(same<decltype(palpate_read_coupling), int32_t(Asked, palpate_coupling_state*)>);
static_assert(same<decltype(palpate_pull), int32_t(Simulation, int32_t, const double*)>);
static_assert(same<palpate_tick_call, void (*)(void*, const palpate_state*)>);
static_assert(same<decltype(palpate_on_tick), int32_t(Simulation, palpate_tick_call, void*)>);
static_assert(same<decltype(palpate_set_gravity), int32_t(Simulation, const double*)>);
static_assert(same<decltype(palpate_set_force), int32_t(Simulation, int32_t, const double*)>);
