#include "mtled/scan/import_scan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/image_file.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "io/text_file.h"
#include "mtled/scan/mask_surface.h"
#include "mtled/scan/phantom_command.h"
#include "mtled/scan/warp_command.h"
#include "mtled/solve/solve_command.h"
#include "support/captured_output.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Matchers::Contains;

namespace {

/// A phantom of voxels of 6 mm and a few electrodes, in files.
ImportScanOptions smallPhantom(const TempFolder& folder) {
  PhantomCommandOptions options;
  options.phantom.voxels = 32;
  options.phantom.rows = 2;
  options.phantom.columns = 8;  // 10 mm apart: some are joined
  options.phantom.shift = 6e-3;
  options.out = folder.path("phantom");
  REQUIRE(phantomCommand(options) == 0);
  ImportScanOptions import;
  import.scan = folder.path("phantom/scan.nii.gz");
  import.mask = folder.path("phantom/mask.nii.gz");
  import.electrodes = folder.path("phantom/electrodes.csv");
  import.frame = "ras";
  import.nodes = 150;
  import.out = folder.path("case");
  return import;
}

}  // namespace

TEST_CASE("From a scan to a warped scan: import, solve, warp", "[import_scan][whole]") {
  TempFolder folder;
  ::setenv("PALPATE_CACHE_DIR", folder.path("cache").c_str(), 1);
  CapturedOutput output;
  const ImportScanOptions import = smallPhantom(folder);
  REQUIRE(importScan(import) == 0);
  const auto report = nlohmann::json::parse(readWholeFile(folder.path("case/report.json")));
  CHECK(std::abs(report.at("surface").at("volume_error").get<double>()) < 5e-3);
  CHECK(report.at("nodes").get<int>() > 80);
  CHECK(report.at("nodes").get<int>() < 350);
  CHECK(report.at("classes").size() == 3);

  WarpOptions warp;
  warp.folder = import.out;
  warp.image = import.scan;
  CHECK_THAT(refusal([&] { warpCommand(warp); }), Contains("checkpoint.bin"));  // it was not solved yet

  SolveOptions solve;
  solve.scene = import.out;
  solve.use_cache = true;
  REQUIRE(solveCommand(solve) == 0);

  REQUIRE(warpCommand(warp) == 0);
  const auto warped = nlohmann::json::parse(readWholeFile(folder.path("case/warp.json")));
  CHECK(warped.at("sampling_error_mean_mm").get<double>() < 0.02);
  CHECK(warped.at("sampling_error_max_mm").get<double>() < 0.1);
  CHECK(warped.at("largest_displacement_mm").get<double>() == Approx(6).epsilon(0.25));
  // What was pushed in left space, which is not valid.
  const Image before = readImage(import.scan), after = readImage(folder.path("case/warped.nii.gz"));
  const Image valid = readImage(folder.path("case/valid.nii.gz"));
  CHECK(sameGrid(before.grid, after.grid));
  CHECK(warped.at("voxels_left_empty").get<int>() > 5);
  CHECK(std::count(valid.value.begin(), valid.value.end(), 0.0F) == warped.at("voxels_left_empty").get<int>());
  for (const char* file : {"field.nii.gz", "forward.nii.gz", "jacobian.nii.gz", "csf.nii.gz", "mask.nii.gz"})
    CHECK(std::filesystem::exists(folder.path(std::string("case/") + file)));

  warp.image = folder.path("phantom/labels.nii.gz");
  warp.labels = true;
  warp.out = folder.path("labels");
  REQUIRE(warpCommand(warp) == 0);
  const Image labels = readImage(folder.path("labels/warped.nii.gz"));
  CHECK(std::all_of(labels.value.begin(), labels.value.end(),
                    [](float a) { return a == 0 || a == 1 || a == 2 || a == 3; }));

  warp.image = folder.path("labels/warped.nii.gz");  // its own result: a second time would be twice as far
  CHECK_THAT(refusal([&] { warpCommand(warp); }), Contains("warped.nii.gz") && Contains("would be written over"));

  Image shares = readImage(import.scan);
  for (float& a : shares.value) a = 0.4F;
  warp.image = folder.path("shares.nii");
  writeImage(warp.image, shares, NiftiType::Float32);
  CHECK_THAT(refusal([&] { warpCommand(warp); }), Contains("shares.nii: 0.4") && Contains("is no label"));
  warp.labels = false;
  shares.grid.origin.x() += 5;
  writeImage(warp.image, shares, NiftiType::Float32);
  CHECK_THAT(refusal([&] { warpCommand(warp); }), Contains("shares.nii: no voxel is in the body of"));
  ::unsetenv("PALPATE_CACHE_DIR");
}

TEST_CASE("Scans that can't be imported are refused with what is missing", "[import_scan]") {
  TempFolder folder;
  CapturedOutput output;
  const ImportScanOptions good = smallPhantom(folder);
  const auto refused = [&](const auto& change) {
    ImportScanOptions options = good;
    change(options);
    return refusal([&] { importScan(options); });
  };
  CHECK_THAT(refused([](auto& o) { o.mask = ""; }), Contains("--mask"));
  CHECK_THAT(refused([](auto& o) { o.labels = o.mask; }), Contains("both"));
  CHECK_THAT(refused([](auto& o) { o.labels = std::exchange(o.mask, ""); }), Contains("--label"));
  CHECK_THAT(refused([&](auto& o) {
               o.labels = folder.path("phantom/labels.nii.gz");
               o.mask = "";
               o.label = {7};
             }),
             Contains("labels right"));
  CHECK_THAT(refused([&](auto& o) {
               o.labels = folder.path("phantom/labels.nii.gz");
               o.mask = "";
               o.label = {614454280};
             }),
             Contains("the label 614454280 is too large"));
  CHECK_THAT(refused([](auto& o) {
               o.frame = "";
               o.classes = 0;
             }),
             Contains("--frame"));
  CHECK_THAT(refused([](auto& o) { o.scan = o.electrodes; }), Contains("NIfTI"));
  CHECK_THAT(refused([](auto& o) { o.opened = {"0,0,80,20"}; }), Contains("--skull"));
  CHECK_THAT(refused([](auto& o) { o.fix = {"1,2,3"}; }), Contains("X,Y,Z,R"));
  CHECK_THAT(refused([](auto& o) { o.fix = {"1,2,3,0"}; }), Contains("X,Y,Z,R"));
  CHECK_THAT(refused([](auto& o) { o.fix = {"1,2,3,4,5"}; }), Contains("X,Y,Z,R"));
  CHECK_FALSE(std::filesystem::exists(folder.path("case")));
  // Found late, when files were written: they go, too.
  CHECK_THAT(refused([](auto& o) {
               o.classes = 0;
               o.fix = {"0,0,-500,20"};
             }),
             Contains("mm from the middle of this ball"));
  CHECK_THAT(refused([](auto& o) {
               o.classes = 0;
               o.fix = {"0,0,0,500"};
             }),
             Contains("give a smaller ball"));
  Mask elsewhere = maskOf(readImage(good.mask), {});
  elsewhere.grid.origin.x() += 1;
  writeImage(folder.path("elsewhere.nii.gz"), elsewhere);
  CHECK_THAT(refused([&](auto& o) { o.mask = folder.path("elsewhere.nii.gz"); }), Contains("outside of the scan"));
  // A sheet of a single layer of voxels, and crumbs.
  Mask thin = maskOf(readImage(good.mask), {});
  for (int k = 0; k < thin.grid.size[2]; ++k)
    for (int j = 0; j < thin.grid.size[1]; ++j)
      for (int i = 0; i < thin.grid.size[0]; ++i) thin(i, j, k) &= k == thin.grid.size[2] / 2;
  writeImage(folder.path("thin.nii.gz"), thin);
  Mask crumbs(thin.grid);
  crumbs(9, 9, 9) = crumbs(12, 9, 9) = 1;
  writeImage(folder.path("crumbs.nii.gz"), crumbs);
  CHECK_THAT(refused([&](auto& o) { o.mask = folder.path("thin.nii.gz"); }),
             Contains("thin.nii.gz: ") && Contains("so thin"));
  CHECK_THAT(refused([&](auto& o) { o.mask = folder.path("crumbs.nii.gz"); }),
             Contains("crumbs.nii.gz: ") && Contains("only 1 voxels"));
  CHECK_FALSE(std::filesystem::exists(folder.path("case")));
  // A case beside its own mask would replace that.
  CHECK_THAT(refused([&](auto& o) { o.out = folder.path("phantom"); }), Contains("another --out"));
  CHECK(std::filesystem::exists(good.mask));
}

TEST_CASE("What a scan or its mask has of its own is told: zeros, values between, tails", "[import_scan]") {
  TempFolder folder;
  ::setenv("PALPATE_CACHE_DIR", folder.path("cache").c_str(), 1);
  CapturedOutput output;
  ImportScanOptions import = smallPhantom(folder);
  import.electrodes = import.frame = "";
  import.open = false;
  const auto reported = [&] {
    REQUIRE(importScan(import) == 0);
    return nlohmann::json::parse(readWholeFile(folder.path("case/report.json")));
  };
  const nlohmann::json whole = reported();
  // A rim cut away by the skull's stripping, of which the mask knows nothing; and values between 0 and 1.
  Image scan = readImage(import.scan), mask = readImage(import.mask);
  const Mask organ = maskOf(mask);
  const auto [nx, ny, nz] = organ.grid.size;
  std::size_t zeros = 0;
  for (int k = 1; k < nz - 1; ++k)
    for (int j = 1; j < ny - 1; ++j)
      for (int i = 1; i < nx - 1; ++i)
        if (organ(i, j, k) && !(organ(i - 1, j, k) && organ(i + 1, j, k))) {
          scan(i, j, k) = 0;
          ++zeros;
        }
  for (float& a : mask.value) a *= 0.7F;
  import.scan = folder.path("stripped.nii");
  import.mask = folder.path("parts.nii");
  writeImage(import.scan, scan, NiftiType::Float32);
  writeImage(import.mask, mask, NiftiType::Float32);
  const nlohmann::json stripped = reported();
  CHECK(stripped.at("zero_voxels").get<double>() > 0.9 * static_cast<double>(zeros));
  for (std::size_t c = 0; c < 3; ++c)
    CHECK(stripped.at("classes")[c].at("centre").get<double>() ==
          Approx(whole.at("classes")[c].at("centre").get<double>()).epsilon(0.25));
  CHECK_THAT(stripped.at("warnings").dump(), Contains("exactly 0") && Contains("up to 0.7"));
  CHECK_THAT(readWholeFile(folder.path("case/scene.toml")), Contains("mask = \"known.nii.gz\""));
  // A tail of a voxel, longer than the nodes are apart.
  Mask tailed = organ;
  const int i = nx / 2, j = ny / 2;
  int low = 0;
  while (!organ(i, j, low)) ++low;
  for (int k = std::max(0, low - 7); k < low; ++k) tailed(i, j, k) = 1;
  import.mask = folder.path("tailed.nii");
  import.scan = folder.path("phantom/scan.nii.gz");
  import.spacing_mm = 18;
  writeImage(import.mask, tailed);
  const nlohmann::json cut = reported();
  CHECK_THAT(cut.at("warnings").dump(), Contains("tails thinner than"));
  CHECK(cut.at("mask_voxels").get<std::size_t>() < countOf(tailed));
  CHECK(cut.at("mask_voxels").get<std::size_t>() > 0.99 * static_cast<double>(countOf(organ)));
  // A mask that reaches beyond the scan, whose edge then cuts the organ.
  Mask beyond = organ;
  beyond.grid.origin.x() += 0.4 * nx * beyond.grid.spacing().x();
  import.mask = folder.path("beyond.nii");
  writeImage(import.mask, beyond);
  CHECK_THAT(reported().at("warnings").dump(),
             Contains("are outside of the scan: left out") && Contains("the organ reaches the image's edge at "));
  // Which electrode is where it is held, before anything is made.
  import = smallPhantom(folder);
  import.fix = {"0,0,80,60"};
  CHECK_THAT(refusal([&] { importScan(import); }),
             Contains("electrodes.csv:") && Contains("--fix 0,0,80,60") && Contains("lines"));
  ::unsetenv("PALPATE_CACHE_DIR");
}

TEST_CASE("Import opens a skull and holds the organ where it is told to", "[import_scan][whole]") {
  TempFolder folder;
  ::setenv("PALPATE_CACHE_DIR", folder.path("cache").c_str(), 1);
  CapturedOutput output;
  ImportScanOptions import = smallPhantom(folder);
  import.electrodes = "";
  import.frame = "lps";
  import.classes = 0;
  import.skull = true;
  import.opened = {"0,0,80,40"};
  import.fix = {"-20,10,-60,40", "20,10,-60,40"};
  REQUIRE(importScan(import) == 0);
  const Scene scene = readScene(folder.path("case/scene.toml"));
  REQUIRE(scene.boundaries.size() == 2);
  CHECK((scene.boundaries[0].region.point - Vec3(0.02, -0.01, -0.06)).norm() < 1e-9);  // in RAS
  CHECK(readWholeFile(folder.path("case/scene.toml")).find("open = [{ shape = \"sphere\"") != std::string::npos);
  ::unsetenv("PALPATE_CACHE_DIR");
}

TEST_CASE("A surface around a mask has its volume, whatever the voxels' axes", "[import_scan]") {
  for (const double sign : {1.0, -1.0}) {
    const Mat3 axes = Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).toRotationMatrix() *
                      Vec3(sign * 2e-3, 2.5e-3, 4e-3).asDiagonal();
    Mask mask(ImageGrid({34, 28, 18}, axes, -axes * Vec3(16.5, 13.5, 8.5)));
    for (int k = 0; k < 18; ++k)
      for (int j = 0; j < 28; ++j)
        for (int i = 0; i < 34; ++i)
          mask(i, j, k) = mask.grid.worldOf(i, j, k).cwiseQuotient(Vec3(0.026, 0.022, 0.02)).norm() < 1;
    const MaskSurface made = surfaceOf(mask, 5e-3, 3e-3);
    CHECK(std::abs(made.volume / made.mask_volume - 1) < 5e-3);
    CHECK(made.distance_95 < 2.5e-3);  // half a voxel's diagonal
    CHECK(made.surface.triangles.size() > 300);
  }
}
