#include "io/certificate.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "support/temp_folder.h"

using namespace palpate;

TEST_CASE("A certificate comes back as it was written, for its own model only, and damaged as none", "[certificate]") {
  const TempFolder folder;
  CHECK(certificateFile("scenes/liver.toml") == "scenes/liver.certificate.json");
  Certificate c;
  c.model_hash = 0x123456789abcdef0;
  c.script = "drag";
  c.row = {{0.004, 0.1, 0.05, 0.01}, {0.012, 0.5, 0.02, 0.005}};
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
  CHECK(back->row[1].error == 0.02);
  CHECK(back->row[1].uncertainty == 0.005);
  CHECK_FALSE(readCertificate(file, c.model_hash + 1));
  CHECK_FALSE(readCertificate(folder.path("none.json"), c.model_hash));
  for (const char* text : {"", "{", "[]", "{\"model_hash\": \"123456789abcdef0\"}", "3"}) {
    std::ofstream(file) << text;
    CHECK_FALSE(readCertificate(file, c.model_hash));
  }
}

TEST_CASE("What a certificate says of a depth, and beyond", "[certificate]") {
  Certificate c;
  c.row = {{0.004, 0.1, 0.05, 0.01}, {0.012, 0.5, 0.02, 0.005}};
  CHECK(certifiedText(c, -0.001) == "±6 % (certified to 12 mm)");
  CHECK(certifiedText(c, 0.0041) == "±2.5 % (certified to 12 mm)");
  CHECK(certifiedText(c, 0.013) == "beyond the certified 12 mm");
}
