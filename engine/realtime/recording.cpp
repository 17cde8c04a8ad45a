#include "realtime/recording.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <stdexcept>
#include <string_view>

#include "base/input_error.h"
#include "base/instruction_set.h"
#include "simulation/model.h"

namespace palpate {
namespace {

constexpr const char* kMagic = "palpate-recording";
constexpr int kVersion = 1;

std::string shortest(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

std::string hex16(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

void append(std::string& line, std::initializer_list<double> values) {
  for (const double value : values) line += " " + shortest(value);
}

std::string lineOf(const TimedRequest& change) {
  const Request& r = change.request;
  std::string line = std::to_string(change.tick);
  switch (r.kind) {
    case Request::Kind::MoveTool: {
      const Vec3& p = r.pose.position;
      const Quat& q = r.pose.orientation;
      line += " tool";
      append(line, {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
      break;
    }
    case Request::Kind::Pull:
      line += " pull " + std::to_string(r.index);
      append(line, {r.point.x(), r.point.y(), r.point.z()});
      break;
    case Request::Kind::ReleasePull:
      line += " release";
      break;
    case Request::Kind::SetFriction:
      line += " friction";
      append(line, {r.value});
      break;
    case Request::Kind::SetMaterial: {
      const Material& m = r.material;
      line += " material " + std::to_string(r.index);
      if (m.kind == Material::Kind::NeoHookean) {
        line += " neo_hookean";
        append(line, {m.shear_modulus, m.bulk_modulus, m.density});
        break;
      }
      line += " ogden";
      append(line, {m.shear_modulus, m.bulk_modulus, m.density});
      line += " " + std::to_string(m.term_count);
      for (std::size_t k = 0; k < static_cast<std::size_t>(m.term_count); ++k) append(line, {m.mu[k], m.alpha[k]});
      break;
    }
    case Request::Kind::Reset:
      line += " reset";
      break;
    default:
      throw std::invalid_argument("a recording holds only what moves the physics");
  }
  return line;
}

/// Reads one line's words; every error names the line.
class LineReader {
 public:
  LineReader(const std::string& file, int number, std::string_view line)
      : file_(file), number_(number), line_(line) {}

  [[noreturn]] void fail(const std::string& problem,
                         const std::string& advice = "record the run again") const {
    throw InputError({file_, number_, static_cast<int>(word_begin_) + 1}, problem, advice);
  }

  bool atEnd() {
    while (next_ < line_.size() && (line_[next_] == ' ' || line_[next_] == '\t' || line_[next_] == '\r')) ++next_;
    return next_ == line_.size();
  }

  std::string_view word(const char* what) {
    const bool end = atEnd();
    word_begin_ = next_;
    if (end) fail(std::string("the line ends before ") + what);
    while (next_ < line_.size() && line_[next_] != ' ' && line_[next_] != '\t' && line_[next_] != '\r') ++next_;
    return line_.substr(word_begin_, next_ - word_begin_);
  }

  std::string rest(const char* what) {
    word(what);
    std::string_view text = line_.substr(word_begin_);
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
    next_ = line_.size();
    return std::string(text);
  }

  double number(const char* what) {
    const std::string_view text = word(what);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      fail(quoted(text) + " is not " + what);
    }
    return value;
  }

  std::size_t wordLength() const { return next_ - word_begin_; }

  template <class Integer>
  Integer integer(const char* what, int base = 10) {
    const std::string_view text = word(what);
    Integer value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc() || end != text.data() + text.size()) fail(quoted(text) + " is not " + what);
    return value;
  }

  Vec3 vector(const char* what) {
    const double x = number(what), y = number(what), z = number(what);
    return {x, y, z};
  }

  void expect(const char* word_wanted) {
    const std::string_view text = word(word_wanted);
    if (text != word_wanted) fail(quoted(text) + " stands where " + quoted(word_wanted) + " should");
  }

  void done() {
    if (atEnd()) return;
    word_begin_ = next_;
    fail("the line goes on after its end");
  }

 private:
  const std::string& file_;
  int number_;
  std::string_view line_;
  std::size_t next_ = 0, word_begin_ = 0;
};

Material readMaterial(LineReader& line) {
  const std::string_view kind = line.word("a material kind");
  Material material;
  if (kind == "ogden") {
    material.kind = Material::Kind::Ogden;
  } else if (kind != "neo_hookean") {
    line.fail(quoted(kind) + " is not a material kind");
  }
  material.shear_modulus = line.number("a shear modulus, Pa");
  material.bulk_modulus = line.number("a bulk modulus, Pa");
  material.density = line.number("a density, kg/m^3");
  if (material.kind == Material::Kind::Ogden) {
    material.term_count = line.integer<int>("a number of terms");
    if (material.term_count < 1 || material.term_count > Material::max_terms) line.fail("so many terms can't be");
    for (std::size_t k = 0; k < static_cast<std::size_t>(material.term_count); ++k) {
      material.mu[k] = line.number("a term's mu, Pa");
      material.alpha[k] = line.number("a term's alpha");
    }
  }
  return material;
}

Request readChange(LineReader& line) {
  const std::string_view what = line.word("what changed");
  if (what == "tool") {
    Pose pose;
    pose.position = line.vector("a coordinate, m");
    const double w = line.number("a quaternion's number");
    const Vec3 v = line.vector("a quaternion's number");
    pose.orientation = Quat(w, v.x(), v.y(), v.z());
    if (std::abs(pose.orientation.norm() - 1) > 1e-6) line.fail("the tool's quaternion is not of length 1");
    return Request::moveTool(pose);
  }
  if (what == "pull") {
    const int vertex = line.integer<int>("a skin vertex");
    if (vertex < 0) line.fail("a skin vertex can't be negative");
    return Request::pull(vertex, line.vector("a coordinate, m"));
  }
  if (what == "release") return Request::simple(Request::Kind::ReleasePull);
  if (what == "reset") return Request::simple(Request::Kind::Reset);
  if (what == "friction") return Request::setFriction(line.number("a friction coefficient"));
  if (what == "material") {
    const int index = line.integer<int>("a material's index");
    return Request::setMaterial(index, readMaterial(line));
  }
  line.fail(quoted(what) + " is not a change that a recording can hold");
}

/// FNV-1a over the bytes of values without padding.
class Hash {
 public:
  template <class T>
  void add(const T& value) {
    addBytes(&value, sizeof value);
  }
  template <class T, class A>
  void add(const std::vector<T, A>& values) {
    add(static_cast<std::uint64_t>(values.size()));
    addBytes(values.data(), values.size() * sizeof(T));
  }
  std::uint64_t value() const { return value_; }

 private:
  void addBytes(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t b = 0; b < size; ++b) value_ = (value_ ^ bytes[b]) * 0x100000001b3ULL;
  }
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace

std::uint64_t modelHash(const Model& model) {
  Hash hash;
  hash.add(model.X);
  hash.add(model.point_X);
  hash.add(model.inverse_mass);
  hash.add(static_cast<int>(chosenInstructionSet()));  // the kernel's rounding depends on it
  hash.add(model.kernel.node);
  hash.add(model.kernel.short_node);
  hash.add(model.kernel.gradN);
  hash.add(model.kernel.rounded_gradN);
  hash.add(model.kernel.scale);
  hash.add(model.kernel.volume);
  hash.add(model.kernel.batch_material);
  hash.add(model.kernel.patch_begin);
  hash.add(model.kernel.patch_point);
  hash.add(model.kernel.patch_node);
  hash.add(model.kernel.patch_share);
  hash.add(model.kernel.patch_weight);
  for (const Material& m : model.materials) {
    hash.add(static_cast<int>(m.kind));
    hash.add(m.shear_modulus);
    hash.add(m.bulk_modulus);
    hash.add(m.term_count);
    hash.add(m.mu);
    hash.add(m.alpha);
    hash.add(m.barrier_strength);
    hash.add(m.barrier_J0);
  }
  for (const EssentialBoundary::Set& set : model.boundary.sets) {
    hash.add(set.mask);
    hash.add(set.node);
    hash.add(set.boundary);
    hash.add(set.phi.value);
    hash.add(set.v.value);
    hash.add(set.u.value);
  }
  for (const BoundaryMotion& motion : model.boundary.motions) {
    hash.add(motion.translation);
    hash.add(motion.axis_point);
    hash.add(motion.axis);
    hash.add(motion.angle);
    hash.add(motion.duration);
    hash.add(static_cast<int>(motion.curve.kind));
    hash.add(motion.curve.time);
    hash.add(motion.curve.fraction);
  }
  hash.add(model.skin.surface.vertices);
  hash.add(model.skin.area);
  hash.add(model.skin.node);
  hash.add(model.skin.N);
  hash.add(model.skin.bulk_stiffness);
  hash.add(static_cast<int>(model.scene.tool.kind));
  hash.add(model.scene.tool.radius);
  hash.add(model.scene.tool.length);
  hash.add(model.scene.tool.edge_radius);
  hash.add(model.tool_start.position);
  hash.add(model.tool_start.orientation.coeffs());
  hash.add(model.scene.tool_max_speed);
  hash.add(model.scene.friction);
  hash.add(model.scene.damping);
  hash.add(model.scene.rate_hz);
  hash.add(model.dt);
  hash.add(model.substeps_per_tick);
  hash.add(model.max_increment);
  return hash.value();
}

void writeRecording(const Recording& recording, const std::string& file) {
  std::string text;
  text += std::string(kMagic) + " " + std::to_string(kVersion) + "\n";
  text += "scene " + recording.scene + "\n";
  text += "model " + hex16(recording.model_hash) + "\n";
  text += "rate_hz " + shortest(recording.rate_hz) + "\n";
  for (const TimedRequest& change : recording.changes) text += lineOf(change) + "\n";
  text += "end " + std::to_string(recording.ticks) + "\n";
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file + ": the recording can't be written");
}

Recording readRecording(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError({file}, "the recording can't be opened", "check the path");

  Recording recording;
  std::string text;
  int number = 0;
  const auto header = [&](const char* key) {
    ++number;
    if (!std::getline(in, text)) throw InputError({file, number}, quoted(key) + " is missing", "record the run again");
    LineReader line(file, number, text);
    line.expect(key);
    return line;
  };
  {
    LineReader line = header(kMagic);
    const int version = line.integer<int>("a version");
    if (version != kVersion) {
      line.fail("version " + std::to_string(version) + " is not known", "this program reads version 1");
    }
    line.done();
  }
  {
    LineReader line = header("scene");
    if (!line.atEnd()) recording.scene = line.rest("the scene's name");
  }
  {
    LineReader line = header("model");
    recording.model_hash = line.integer<std::uint64_t>("a hash of 16 hex digits", 16);
    if (line.wordLength() != 16) line.fail("the model's hash has not 16 hex digits");
    line.done();
  }
  {
    LineReader line = header("rate_hz");
    recording.rate_hz = line.number("a rate, Hz");
    if (recording.rate_hz <= 0) line.fail("the rate must be positive");
    line.done();
  }

  std::int64_t last = 0;
  while (std::getline(in, text)) {
    ++number;
    LineReader line(file, number, text);
    if (line.atEnd()) continue;
    if (text.starts_with("end")) {
      line.expect("end");
      recording.ticks = line.integer<std::int64_t>("a number of ticks");
      if (in.eof()) line.fail("the recording is cut off within this line: no line end follows");
      if (recording.ticks < last) line.fail("the run ends before its last change");
      line.done();
      while (std::getline(in, text)) {
        LineReader after(file, ++number, text);
        if (!after.atEnd()) after.fail("something stands after the end");
      }
      return recording;
    }
    TimedRequest change;
    change.tick = line.integer<std::int64_t>("a tick");
    if (change.tick < last) line.fail("ticks must not go back");
    last = change.tick;
    change.request = readChange(line);
    line.done();
    recording.changes.push_back(change);
  }
  throw InputError({file, number}, "the recording is cut off after this line: 'end' is missing", "record the run again");
}

void checkRecordingFits(const Recording& recording, const Model& model, const std::string& file) {
  constexpr int kModelLine = 3, kRateLine = 4;
  if (recording.rate_hz != model.scene.rate_hz) {
    throw InputError({file, kRateLine},
                     "recorded at " + shortest(recording.rate_hz) + " Hz, but the scene runs at " +
                         shortest(model.scene.rate_hz) + " Hz",
                     "replay with --rate " + shortest(recording.rate_hz));
  }
  const std::uint64_t hash = modelHash(model);
  if (recording.model_hash != hash) {
    throw InputError({file, kModelLine},
                     "recorded with model " + hex16(recording.model_hash) + " (scene " + palpate::quoted(recording.scene) +
                         "), but this one is " + hex16(hash) + " (scene " + palpate::quoted(model.scene.name) + ")",
                     "replay with the scene, program, machine and PALPATE_KERNEL it was recorded with");
  }
}

std::vector<TimedRequest> trackFromPoses(const std::vector<Pose>& poses) {
  std::vector<TimedRequest> track;
  track.reserve(poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    track.push_back({static_cast<std::int64_t>(k), Request::moveTool(poses[k])});
  }
  return track;
}

}  // namespace palpate
