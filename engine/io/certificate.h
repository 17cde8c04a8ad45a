#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace palpate {

/// What `mtled certify` found about a scene: how far its force is from the limit of fine clouds, over depth. It holds
/// for the model with that hash, on the way that was pressed.
struct Certificate {
  static constexpr double first_from = 0.5;  // of the first row's advance, above which nothing is certified

  /// Of the ticks deeper than the row before whose force is at least a fifth of their largest.
  struct Row {
    double advance = 0;      // m, of the tool's tip past first touch, the row's end
    double force = 0;        // N, at the end, extrapolated
    double scene_force = 0;  // N, at the end, the scene's own
    double error = 0;        // largest distance of the scene's force from the extrapolated one, over that
    double uncertainty = 0;  // largest share of the extrapolated force that is not known

    double bound() const { return error + uncertainty; }
  };
  std::uint64_t model_hash = 0;
  std::string script;     // of the tool's way; "": the built-in indentation
  std::vector<Pose> way;  // of the tool, thinned out
  std::vector<Row> row;   // by advance
  /// Root mean square, of the skin's displacements at the end, over the largest. Not a number: the tool has let go.
  double displacement_error = 0;

  /// The row that holds at that advance; none where it is beyond all, or above first_from.
  const Row* at(double advance) const;
  double deepest() const { return row.empty() ? 0 : row.back().advance; }
  /// The largest bound() of all rows; infinite without any.
  double worst() const;
  /// Whether a tool is on the way, or deeper at its end: by at most 5 degrees turned, and so far beside it.
  /// @param beside  m
  bool isOnWay(const Pose& tool, double advance, double beside) const;
};

/// Whether one way of one tool tells the scene's force: neither further tools nor jaws move beside it.
bool hasOneWay(const Scene& scene);

/// Where a scene's certificate lies: beside it, "liver.toml" -> "liver.certificate.json".
std::string certificateFile(const std::string& scene_file);

/// Writes it as a whole or not at all. Throws std::runtime_error where it can't.
void writeCertificate(const std::string& file, const Certificate& certificate);

/// None where there is no such file, or it is damaged, of another program or another model: then nothing is known.
/// @param refused  receives why a file that is there is not used
/// Test: io/certificate_test.cpp
std::optional<Certificate> readCertificate(const std::string& file, std::uint64_t model_hash,
                                           std::string* refused = nullptr);

/// "±1.5 % (certified to 12 mm)", or that the tool is not where it was certified.
std::string certifiedText(const Certificate& certificate, double advance);

/// Which way it holds for, and the errors at its first and last row.
std::string certifiedWay(const Certificate& certificate);

}  // namespace palpate
