#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace palpate {

/// What `mtled certify` found about a scene: how far its force is from the limit of fine clouds, over depth. It holds
/// for the model with that hash, and the way that was pressed.
struct Certificate {
  struct Row {
    double advance = 0;      // m, of the tool's tip past first touch, the row's end
    double force = 0;        // N, the largest up to there, extrapolated
    double error = 0;        // root mean square of the force's error up to there, over `force`
    double uncertainty = 0;  // of that error: as much of it is not known
  };
  std::uint64_t model_hash = 0;
  std::string script;             // of the tool's way; "": the built-in indentation
  std::vector<Row> row;           // by advance
  double displacement_error = 0;  // likewise, of the skin's displacements at the end, over the largest

  /// The row that holds at that advance; none where it is beyond all.
  const Row* at(double advance) const;
  double deepest() const { return row.empty() ? 0 : row.back().advance; }
};

/// Whether one way of one tool tells the scene's force: neither further tools nor jaws move beside it.
bool hasOneWay(const Scene& scene);

/// Where a scene's certificate lies: beside it, "liver.toml" -> "liver.certificate.json".
std::string certificateFile(const std::string& scene_file);

/// Writes it as a whole or not at all. Throws std::runtime_error where it can't.
void writeCertificate(const std::string& file, const Certificate& certificate);

/// None where there is no such file, or it is damaged, or of another model: then nothing is known.
/// Test: io/certificate_test.cpp
std::optional<Certificate> readCertificate(const std::string& file, std::uint64_t model_hash);

/// "±1.5 % (certified to 12 mm)", or that the tool is beyond what was certified.
std::string certifiedText(const Certificate& certificate, double advance);

}  // namespace palpate
