#include "mtled/solve/solve_results.h"

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/build_info.h"
#include "discretization/surface/surface_tree.h"
#include "io/csv_table.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "model/solution_fields.h"
#include "mtled/solve/solve_tools.h"
#include "scene/scene_messages.h"
#include "scene/scene_rigid.h"
#include "setup/body_points.h"
#include "step/trust.h"

namespace palpate::tools {
namespace {

constexpr std::size_t first_reaction = 4;  // its column
constexpr const char* error_column = "expected_force_error";

std::string frameName(std::size_t k) {
  char name[32];
  std::snprintf(name, sizeof name, "solution_%04d.vtu", static_cast<int>(k));
  return name;
}

nlohmann::json listed(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

bool isJaws(const Model& model, int tool) { return model.tools.tool[static_cast<std::size_t>(tool)].jaws; }

}  // namespace

SolveResults::SolveResults(const Model& model, const std::string& folder, double end, std::uint64_t identity,
                           bool resume)
    : model_(model), folder_(folder), end_(end) {
  makeFolder(folder);
  readProbePoints();
  const std::vector<std::string> names = columns();
  CsvTable kept;
  if (resume) {
    kept = takeUp(identity, names);
  } else {
    checkpoint_.model_hash = identity;
    checkpoint_.u.resize(model.X.size());
    checkpoint_.du.resize(model.X.size());
  }
  force_ = std::make_unique<ResultCsv>(forceFile(), names);
  for (std::int64_t r = 0; r < checkpoint_.rows; ++r) {
    std::vector<double> row;
    for (std::size_t c = 0; c + 1 < kept.column.size(); ++c) row.push_back(kept.column[c][static_cast<std::size_t>(r)]);
    const std::string& trust = kept.trust[static_cast<std::size_t>(r)];
    force_->add(row, trust);
    remember(doubtNamed(trust), row, {});
    last_row_ = std::move(row);
  }
  const double* at = last_row_.empty() ? nullptr : last_row_.data() + first_reaction;
  for (std::size_t b = 0; at != nullptr && b < model.scene.boundaries.size(); ++b, at += 6)
    last_reactions_.push_back({Vec3(at[0], at[1], at[2]), Vec3(at[3], at[4], at[5])});
  // Nothing can be refused any more: what an earlier run left gives way.
  std::error_code ignored;
  if (!resume) std::filesystem::remove(checkpointFile(), ignored);
  force_->takePlace();
  for (std::size_t k = 0; k < checkpoint_.frame_time.size(); ++k)
    pvd_.push_back({checkpoint_.frame_time[k], frameName(k)});
}

void SolveResults::readProbePoints() {
  const Scene& scene = model_.scene;
  if (scene.solve.probes_file.empty()) return;
  const auto place = scene.places.find("solve.probes");
  probes_ = readProbes(scene.solve.probes_file, place == scene.places.end() ? SourceLocation{} : place->second);
  probe_shape_ = shapeAt(model_, probes_.X);
  const SurfaceTree organ(organSurface(scene));
  // The organ's faces are flat where a probe may lie on the round that they stand for.
  const double tolerance = 0.05 * scene.discretization.spacing;
  for (std::size_t k = 0; k < probes_.X.size(); ++k)
    if (organ.signedDistance(probes_.X[k]) > tolerance)
      throw InputError({scene.solve.probes_file, probes_.table.line[k]}, "this point lies outside the body",
                       "move it inside, or leave it out");
}

std::vector<std::string> SolveResults::columns() const {
  std::vector<std::string> columns{"time_s", "iterations", "min_J", "inverted_points"};
  for (const auto& b : model_.scene.boundaries)
    for (const char* part : {"_fx_N", "_fy_N", "_fz_N", "_mx_Nm", "_my_Nm", "_mz_Nm"}) columns.push_back(b.name + part);
  for (int t = 0; t < model_.tools.toolCount(); ++t) {
    for (const char* part : {"_fx_N", "_fy_N", "_fz_N"}) columns.push_back(toolColumn(t) + part);
    if (isJaws(model_, t)) columns.push_back(toolColumn(t) + "_pinch_N");
  }
  for (const RigidBody& body : model_.rigid.body)
    for (const char* part : {"_fx_N", "_fy_N", "_fz_N", "_penetration_m"}) columns.push_back(body.name + part);
  for (const LoadSpec& load : model_.scene.loads)
    for (const char* part : {"_fx_N", "_fy_N", "_fz_N"}) columns.push_back(load.name + part);
  columns.emplace_back(error_column);
  if (model_.scene.solve.mode == SolveSpec::Mode::Static) columns.emplace_back("error_m");
  columns.emplace_back("trust");
  return columns;
}

/// The folder's checkpoint, and the rows of force.csv of which it knows the first ones.
CsvTable SolveResults::takeUp(std::uint64_t identity, const std::vector<std::string>& columns) {
  checkpoint_ = readCheckpoint(checkpointFile(), identity, model_.X.size());
  CsvTable earlier = readCsvTable(forceFile());
  if (earlier.name != columns || static_cast<std::int64_t>(earlier.rowCount()) < checkpoint_.rows)
    throw InputError({forceFile()}, "this file does not belong to the checkpoint", "start without --resume");
  return earlier;
}

void SolveResults::remember(Doubt doubt, const std::vector<double>& row, const std::optional<Vec3>& place) {
  const std::vector<std::string> names = columns();
  double force = 0;
  for (std::size_t c = 0; c < row.size(); ++c) {
    if (names[c].ends_with("_fx_N")) force = std::max(force, Vec3(row.data() + c).norm());
    if (names[c] == error_column) expected_error_ = row[c];
  }
  if (doubt > trust_.doubt()) doubt_place_ = place;
  trust_.add(doubt, expected_error_, force, row.front());
}

void SolveResults::checkHistory(const AlignedVector<double>& solver) const {
  if (checkpoint_.history.size() != solver.size())
    throw InputError({checkpointFile()}, "the checkpoint is damaged", "start without --resume");
}

void SolveResults::compareTools(double time, const ToolsAt& wanted, const ToolsAt& are) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(wanted.count); ++t) {
    const double lacking = (wanted.posture[t].pose.position - are.posture[t].pose.position).norm();
    if (short_of_way_ == 0) short_from_ = time;
    short_of_way_ = std::max(short_of_way_, lacking);
  }
}

/// A tool's way is imposed here, whatever force it takes.
void SolveResults::compareForces(double time, const ToolLoads& loads) {
  const auto compare = [&](int tool, const char* key, double limit, double force) {
    if (!(limit > 0) || !(force > 1.001 * limit)) return;
    auto known = std::find_if(beyond_limit_.begin(), beyond_limit_.end(),
                              [&](const BeyondLimit& b) { return b.tool == tool && b.key == key; });
    if (known == beyond_limit_.end()) known = beyond_limit_.insert(known, {tool, key, limit, force, time});
    known->force = std::max(known->force, force);
  };
  for (int t = 0; t < model_.tools.toolCount(); ++t) {
    const ToolSetUp& tool = model_.tools.tool[static_cast<std::size_t>(t)];
    const ToolLoad& load = loads[static_cast<std::size_t>(t)];
    compare(t, "max_force", tool.max_force, load.force.norm());
    if (isJaws(model_, t)) compare(t, "grip_force", tool.grip_force, load.pinch);
  }
}

void SolveResults::add(const SolvedRow& solved, const BatchBody& body, const ToolsAt& tools) {
  compareTools(solved.time, tools, body.tools());
  std::vector<double> row{solved.time, static_cast<double>(solved.iterations), solved.min_J,
                          static_cast<double>(solved.inverted_points)};
  const auto append = [&](const Vec3& v) { row.insert(row.end(), v.data(), v.data() + 3); };
  for (const auto& r : body.reactions()) {
    append(r.force);
    append(r.moment);
  }
  for (int t = 0; t < model_.tools.toolCount(); ++t) {
    const ToolLoad& load = solved.loads[static_cast<std::size_t>(t)];
    append(load.force);
    if (isJaws(model_, t)) row.push_back(load.pinch);
  }
  last_loads_ = solved.loads;
  compareForces(solved.time, solved.loads);
  for (std::size_t b = 0; b < model_.rigid.body.size(); ++b) {
    append(solved.rigid[b].force);
    row.push_back(solved.rigid[b].max_penetration);
  }
  last_rigid_ = solved.rigid;
  last_load_forces_ = body.loadForces();
  for (const Vec3& force : last_load_forces_) append(force);
  row.push_back(solved.expected_error);
  if (solved.error) row.push_back(*solved.error);
  force_->add(row, doubtName(solved.doubt));
  remember(solved.doubt, row,
           solved.worst_point < 0 ? std::nullopt
                                  : std::optional(model_.point_X[static_cast<std::size_t>(solved.worst_point)]));
  ++checkpoint_.rows;
  checkpoint_.position = solved.position;
  checkpoint_.largest = solved.largest;
  checkpoint_.u = body.u;
  checkpoint_.du = body.du;
  checkpoint_.history = body.history();
  last_reactions_ = body.reactions();
  last_row_ = std::move(row);
  const double next = static_cast<double>(checkpoint_.frame_time.size() + 1) / model_.scene.solve.frames;
  if (solved.time >= end_ * next * (1 - 1e-9)) addFrame(solved.time, body);
  if (Clock::now() - saved_ > std::chrono::seconds(10)) save();
}

void SolveResults::writeProbes() const {
  if (probes_.X.empty()) return;
  ResultCsv csv(folder_ + "/probes.csv", {"X", "Y", "Z", "ux", "uy", "uz"});
  const auto u = fieldAt(probe_shape_, checkpoint_.u);
  for (std::size_t k = 0; k < u.size(); ++k)
    csv.add(std::vector<double>{probes_.X[k].x(), probes_.X[k].y(), probes_.X[k].z(), u[k].x(), u[k].y(), u[k].z()});
  csv.finish();
}

/// What holds each of several tools, or jaws.
nlohmann::json SolveResults::tools() const {
  nlohmann::json all = nlohmann::json::array();
  for (int t = 0; t < model_.tools.toolCount(); ++t) {
    const ToolLoad& load = (*last_loads_)[static_cast<std::size_t>(t)];
    nlohmann::json entry{{"force_N", listed(load.force)}, {"contact_points", load.contact_count}};
    if (isJaws(model_, t)) entry["pinch_N"] = load.pinch;
    all.push_back(std::move(entry));
  }
  return all;
}

void SolveResults::finish(nlohmann::json outcome) {
  force_->finish();
  save();
  writeProbes();
  nlohmann::json reactions;
  for (std::size_t b = 0; b < last_reactions_.size(); ++b)
    reactions[model_.scene.boundaries[b].name] = {{"force_N", listed(last_reactions_[b].force)},
                                                  {"moment_Nm", listed(last_reactions_[b].moment)}};
  outcome.update({{"scene", model_.scene.name},
                  {"nodes", model_.nodeCount()},
                  {"integration_points", model_.pointCount()},
                  {"mean_support", model_.point_shape.meanSupport()},
                  {"rows", checkpoint_.rows},
                  {"frames", checkpoint_.frame_time.size()},
                  {"reactions", reactions},
                  {"trust", checkpoint_.rows > 0 ? nlohmann::json(doubtName(trust_.doubt())) : nullptr},
                  {"setup_seconds", model_.setup_seconds},
                  {"build", buildInfo()}});
  if (trust_.expectedError() > 0) outcome[error_column] = trust_.expectedError();
  if (const Doubt doubt = trust_.doubt(); doubt != Doubt::None) {
    outcome["doubt"] = {{"text", doubtText(doubt)}, {"first_time_s", trust_.firstTime()}};
    if (doubt_place_) outcome["doubt"]["worst_point_m"] = listed(*doubt_place_);
  }
  for (std::size_t b = 0; last_rigid_ && b < model_.rigid.body.size(); ++b) {
    const std::string& name = model_.rigid.body[b].name;
    const RigidLoad& load = (*last_rigid_)[b];
    outcome["rigid"].push_back(
        {{"name", name}, {"force_N", listed(load.force)}, {"penetration_m", load.max_penetration}});
    if (name == skull_name)
      outcome["skull"] = {{"force_N", listed(load.force)}, {"max_penetration_m", load.max_penetration}};
  }
  for (std::size_t l = 0; l < last_load_forces_.size(); ++l)
    outcome["loads"][model_.scene.loads[l].name] = {{"force_N", listed(last_load_forces_[l])}};
  if (model_.tools.several() && last_loads_) outcome["tools"] = tools();
  if (short_of_way_ > 0) outcome["tool_stopped"] = {{"short_m", short_of_way_}, {"first_time_s", short_from_}};
  for (const BeyondLimit& b : beyond_limit_)
    outcome["beyond_limit"].push_back({{"tool", b.tool + 1},
                                       {"key", b.key},
                                       {"limit_N", b.limit},
                                       {"force_N", b.force},
                                       {"first_time_s", b.first_time}});
  if (!last_row_.empty()) {
    outcome["time_s"] = last_row_[0];
    outcome["min_J"] = last_row_[2];
    outcome["inverted_points"] = static_cast<int>(last_row_[3]);
  }
  writeWholeFile(folder_ + "/report.json",
                 outcome.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void SolveResults::print() const {
  std::cout << "force curve  " << forceFile() << "\nParaView     " << folder_ << "/solution.pvd\nreport       "
            << folder_ << "/report.json\n";
  if (!probes_.X.empty()) std::cout << "probes       " << folder_ << "/probes.csv\n";
  std::cout.flush();
  if (short_of_way_ > 0)
    std::cerr << "mtled: from " << number(short_from_) << " s on a tool stands before what is rigid, up to "
              << number(1e3 * short_of_way_) << " mm short of its way\n";
  for (const BeyondLimit& b : beyond_limit_)
    std::cerr << "mtled: from " << number(b.first_time) << " s on the way of tool " << b.tool + 1
              << " takes more than its " << b.key << ", up to " << number(b.force) << " N for " << number(b.limit)
              << ": palpate lets it give way, mtled solve does not\n";
  const Doubt doubt = trust_.doubt();
  if (doubt == Doubt::None) return;
  std::cerr << "mtled: the result is not to be trusted from " << number(trust_.firstTime()) << " s on";
  if (doubt_place_) std::cerr << ", at " << coordinates(*doubt_place_);
  std::cerr << ": " << doubtText(doubt) << "\n";
}

void SolveResults::addFrame(double time, const BatchBody& body) {
  std::vector<Vec3> u;
  u.reserve(body.u.size());
  for (const auto& a : body.u) u.push_back(toVec3(a));
  const SolutionFields fields = solutionFields(model_, u, body.pointHistory(), body.holdingFriction());
  std::vector<Vec3> reaction(model_.X.size(), Vec3::Zero());
  body.addNodeReactions(reaction);
  const std::vector<VtuField> at_nodes{vtuVectors("displacement_m", fields.displacement),
                                       vtuVectors("reaction_N", reaction)};
  const std::vector<VtuField> in_cells{
      {"J", fields.J}, {"von_Mises_Pa", fields.von_mises}, {"pressure_Pa", fields.pressure}};
  const std::string name = frameName(checkpoint_.frame_time.size());
  writeVtu(folder_ + "/" + name, model_.X, model_.cells, at_nodes, in_cells);
  pvd_.push_back({time, name});
  writePvd(folder_ + "/solution.pvd", pvd_);
  checkpoint_.frame_time.push_back(time);
}

void SolveResults::save() {
  writeCheckpoint(checkpointFile(), checkpoint_);
  saved_ = Clock::now();
}

}  // namespace palpate::tools
