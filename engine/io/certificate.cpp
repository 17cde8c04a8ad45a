#include "io/certificate.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/number_text.h"
#include "io/output_file.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr int format_number = 2;         // of the file
constexpr double largest_turn = 0.0873;  // rad, 5 degrees

double distanceToSegment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  const double at = length2 > 0 ? std::clamp((x - a).dot(along) / length2, 0.0, 1.0) : 0;
  return (x - a - at * along).norm();
}

std::string plusMinus(double share) { return format(share < 0.1 ? "±%.2g %%" : "±%.0f %%", 100 * share); }

Json poseJson(const Pose& pose) {
  Json numbers = Json::array();
  for (const double x : pose.position) numbers.push_back(x);
  for (const double q : pose.orientation.coeffs()) numbers.push_back(q);
  return numbers;
}

Pose poseOf(const Json& json) {
  Pose pose;
  for (int i = 0; i < 3; ++i) pose.position[i] = json.at(static_cast<std::size_t>(i));
  for (int i = 0; i < 4; ++i) pose.orientation.coeffs()[i] = json.at(static_cast<std::size_t>(3 + i));
  return pose;
}

Certificate certificateOf(const Json& json) {
  Certificate c;
  c.script = json.at("script");
  const Json& displacement = json.at("displacement_error");  // null: none
  c.displacement_error = displacement.is_null() ? std::nan("") : displacement.get<double>();
  for (const Json& pose : json.at("way")) c.way.push_back(poseOf(pose));
  for (const Json& r : json.at("rows"))
    c.row.push_back(
        {r.at("advance_m"), r.at("force_N"), r.at("scene_force_N"), r.at("largest_error"), r.at("uncertainty")});
  return c;
}

}  // namespace

const Certificate::Row* Certificate::at(double advance) const {
  const auto found = std::find_if(row.begin(), row.end(), [=](const Row& r) { return advance <= r.advance; });
  return found == row.end() || advance < first_from * row.front().advance ? nullptr : &*found;
}

double Certificate::worst() const {
  double worst = row.empty() ? INFINITY : 0;
  for (const Row& r : row) worst = std::max(worst, r.bound());
  return worst;
}

bool Certificate::isOnWay(const Pose& tool, double advance, double beside) const {
  if (way.empty()) return false;
  const Vec3 axis = way.front().orientation * -Vec3::UnitZ();
  const Vec3 tip = tool.position - std::max(0.0, advance - deepest()) * axis;
  for (std::size_t k = 0; k < way.size(); ++k) {
    const Pose &from = way[k > 0 ? k - 1 : 0], &to = way[k];
    if (distanceToSegment(tip, from.position, to.position) <= beside &&
        to.orientation.angularDistance(tool.orientation) <= largest_turn)
      return true;
  }
  return false;
}

bool hasOneWay(const Scene& scene) { return scene.tools.size() == 1 && !scene.tools[0].jaws(); }

std::string certificateFile(const std::string& scene_file) {
  return std::filesystem::path(scene_file).replace_extension(".certificate.json").string();
}

void writeCertificate(const std::string& file, const Certificate& c) {
  Json rows = Json::array(), way = Json::array();
  for (const Certificate::Row& r : c.row)
    rows.push_back({{"advance_m", r.advance},
                    {"force_N", r.force},
                    {"scene_force_N", r.scene_force},
                    {"largest_error", r.error},
                    {"uncertainty", r.uncertainty}});
  for (const Pose& pose : c.way) way.push_back(poseJson(pose));
  const Json json = {{"format", format_number},
                     {"model_hash", hex16(c.model_hash)},
                     {"script", c.script},
                     {"rows", rows},
                     {"displacement_error", c.displacement_error},
                     {"way", way}};
  writeWholeFile(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::optional<Certificate> readCertificate(const std::string& file, std::uint64_t model_hash, std::string* refused) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return {};
  std::string why = "it is damaged";
  try {
    const Json json = Json::parse(in);
    if (json.at("model_hash") != hex16(model_hash)) {
      why = "it is of another scene, or of this one before it was changed";
    } else if (json.value("format", 1) != format_number) {
      why = "it is of another version of the program";
    } else {
      Certificate c = certificateOf(json);
      c.model_hash = model_hash;
      return c;
    }
  } catch (const nlohmann::json::exception&) {
  }
  if (refused != nullptr) *refused = file + " is not used: " + why + "; `mtled certify` measures anew";
  return {};
}

std::string certifiedText(const Certificate& certificate, double advance) {
  const Certificate::Row* const row = certificate.at(advance);
  const double deepest = certificate.deepest();
  if (row != nullptr) return plusMinus(row->bound()) + format(" (certified to %.3g mm)", 1e3 * deepest);
  if (advance > deepest || certificate.row.empty()) return format("beyond the certified %.3g mm", 1e3 * deepest);
  return format("certified from %.2g mm on", 1e3 * Certificate::first_from * certificate.row.front().advance);
}

std::string certifiedWay(const Certificate& certificate) {
  const std::string way = certificate.script.empty() ? "straight in from the tool's start"
                                                     : "on the way of " + inQuotes(certificate.script);
  if (certificate.row.empty()) return "nothing is certified " + way;
  const Certificate::Row &first = certificate.row.front(), &last = certificate.row.back();
  return "the force is certified " + way +
         format(": %s of it at %.2g mm, %s at %.3g mm", plusMinus(first.bound()).c_str(), 1e3 * first.advance,
                plusMinus(last.bound()).c_str(), 1e3 * last.advance);
}

}  // namespace palpate
