#include "io/certificate.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "support/temp_folder.h"

using namespace palpate;

TEST_CASE("A certificate comes back as it was written, for its own model only, and damaged as none", "[certificate]") {
  const TempFolder folder;
  CHECK(certificateFile("scenes/liver.toml") == "scenes/liver.certificate.json");
  Certificate c;
  c.model_hash = 0x123456789abcdef0;
  c.script = "drag";
  c.row = {{0.004, 0.1, 0.104, 0.05, 0.01}, {0.012, 0.5, 0.49, 0.02, 0.005}};
  c.way = {{Vec3(1, 2, 3), Quat(0.5, 0.5, -0.5, 0.5)}};
  c.displacement_error = 0.03;
  const std::string file = folder.path("a.certificate.json");
  writeCertificate(file, c);
  const auto back = readCertificate(file, c.model_hash);
  REQUIRE(back);
  CHECK(back->script == "drag");
  CHECK(back->displacement_error == 0.03);
  REQUIRE(back->row.size() == 2);
  CHECK(back->row[1].advance == 0.012);
  CHECK(back->row[1].force == 0.5);
  CHECK(back->row[1].scene_force == 0.49);
  CHECK(back->row[1].error == 0.02);
  CHECK(back->row[1].uncertainty == 0.005);
  REQUIRE(back->way.size() == 1);
  CHECK(back->way[0].position == Vec3(1, 2, 3));
  CHECK(back->way[0].orientation.coeffs() == c.way[0].orientation.coeffs());
  std::string refused;
  CHECK_FALSE(readCertificate(file, c.model_hash + 1, &refused));
  CHECK_THAT(refused, Catch::Contains("a.certificate.json") && Catch::Contains("before it was changed"));
  refused.clear();
  CHECK_FALSE(readCertificate(folder.path("none.json"), c.model_hash, &refused));
  CHECK(refused.empty());
  c.displacement_error = std::nan("");  // of a tool that has let go
  writeCertificate(file, c);
  REQUIRE(readCertificate(file, c.model_hash));
  CHECK(std::isnan(readCertificate(file, c.model_hash)->displacement_error));
  // What earlier programs wrote has root mean squares over all depths, and no place.
  std::ofstream(file) << R"({"model_hash": "123456789abcdef0", "script": "", "rows": [{"advance_m": 0.004,
    "force_N": 0.1, "force_error": 0.05, "uncertainty": 0.01}], "displacement_error": 0.03})";
  CHECK_FALSE(readCertificate(file, c.model_hash, &refused));
  CHECK_THAT(refused, Catch::Contains("another version") && Catch::Contains("mtled certify"));
  for (const char* text : {"", "{", "[]", "{\"model_hash\": \"123456789abcdef0\"}", "3"}) {
    std::ofstream(file) << text;
    CHECK_FALSE(readCertificate(file, c.model_hash));
  }
}

TEST_CASE("What a certificate says of a depth, above half of its first and beyond", "[certificate]") {
  Certificate c;
  c.row = {{0.004, 0.1, 0.1, 0.05, 0.01}, {0.012, 0.5, 0.5, 0.02, 0.005}};
  CHECK(certifiedText(c, 0.001) == "certified from 2 mm on");
  CHECK(certifiedText(c, 0.002) == "±6 % (certified to 12 mm)");
  CHECK(certifiedText(c, 0.0041) == "±2.5 % (certified to 12 mm)");
  CHECK(certifiedText(c, 0.013) == "beyond the certified 12 mm");
  CHECK(c.worst() == Approx(0.06));
  CHECK_THAT(certifiedWay(c), Catch::Contains("straight in") && Catch::Contains("±6 % of it at 4 mm, ±2.5 % at 12 mm"));
  c.row[0].error = 1.09;
  CHECK(certifiedText(c, 0.003) == "±110 % (certified to 12 mm)");
  CHECK(certifiedText({}, 0.001) == "beyond the certified 0 mm");
  CHECK(Certificate().worst() > 1e9);
}

TEST_CASE("On a certificate's way is what is beside it by no more than a length, and turned by 5 degrees",
          "[certificate]") {
  Certificate c;
  c.row = {{0.004, 0.1, 0.1, 0.05, 0.01}};
  const auto at = [](double x, double z, double degrees = 0) {
    return Pose{Vec3(x, 0, z), Quat(Eigen::AngleAxisd(degrees / 57.2958, Vec3::UnitX()))};
  };
  constexpr double skin = 0.03, beside = 0.0015;
  c.way = {at(0, skin + 0.001), at(0, skin - 0.004), at(0.02, skin - 0.004)};  // in, and along
  const auto isOn = [&](const Pose& pose) { return c.isOnWay(pose, skin - pose.position.z(), beside); };
  CHECK(isOn(at(0.0014, skin - 0.002)));
  CHECK_FALSE(isOn(at(0.0016, skin - 0.002)));
  CHECK(isOn(at(0.015, skin - 0.0045)));
  CHECK_FALSE(isOn(at(0.015, skin - 0.001)));  // where it was only deeper
  CHECK(isOn(at(0, skin - 0.009)));            // beyond is told
  CHECK_FALSE(isOn(at(-0.002, skin - 0.009)));
  CHECK(isOn(at(0, skin - 0.002, 4)));
  CHECK_FALSE(isOn(at(0, skin - 0.002, 6)));
  c.way.clear();
  CHECK_FALSE(isOn(at(0, skin)));
}
