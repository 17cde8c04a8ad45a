#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "imaging/gzip.h"
#include "imaging/nifti.h"
#include "io/image_file.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Matchers::Contains;

namespace {

/// Oblique, anisotropic, sheared a little where asked; its values are whole numbers.
Image sampleImage(bool sheared = false) {
  Mat3 axes = Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix() *
              Vec3(-0.9e-3, 0.9e-3, 2.5e-3).asDiagonal();
  if (sheared) axes.col(1) += 0.1 * axes.col(0);
  Image image(ImageGrid({5, 4, 3}, axes, Vec3(0.031, -0.052, 0.017)));
  for (std::size_t v = 0; v < image.value.size(); ++v) image.value[v] = static_cast<float>(v);
  return image;
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(&bytes[at], &value, sizeof value);
}

std::string plain(const Image& image = sampleImage()) { return niftiFrom(image, NiftiType::Float32, false); }

/// A NIfTI-1 header by hand, 2 x 2 x 2 of int16 with the values 0 .. 7, without sform and qform.
std::string byHand() {
  std::string b(352 + 16, '\0');
  put(b, 0, std::int32_t{348});
  const std::int16_t dim[8] = {3, 2, 2, 2, 1, 1, 1, 1};
  std::memcpy(&b[40], dim, sizeof dim);
  put(b, 70, std::int16_t{4});
  put(b, 72, std::int16_t{16});
  const float pixdim[8] = {1, 1, 2, 3, 1, 1, 1, 1};
  std::memcpy(&b[76], pixdim, sizeof pixdim);
  put(b, 108, 352.0F);
  b[123] = 2;
  std::memcpy(&b[344], "n+1", 4);
  for (std::int16_t v = 0; v < 8; ++v) put(b, 352 + 2 * static_cast<std::size_t>(v), v);
  return b;
}

Image read(const std::string& bytes, const NiftiOptions& options = {}) {
  return imageFromNifti(bytes, "a.nii", options);
}

double cornerDistance(const ImageGrid& a, const ImageGrid& b) {
  return (a.worldOf(4, 3, 2) - b.worldOf(4, 3, 2)).norm() + (a.origin - b.origin).norm();
}

}  // namespace

TEST_CASE("An image that is written reads back where it was, compressed or not", "[imaging][nifti]") {
  for (const bool sheared : {false, true})
    for (const bool compressed : {false, true})
      for (const NiftiType type : {NiftiType::UInt8, NiftiType::Int16, NiftiType::Float32}) {
        const Image image = sampleImage(sheared);
        const Image again = read(niftiFrom(image, type, compressed));
        CHECK(again.value == image.value);
        CHECK(again.grid.size == image.grid.size);
        CHECK(cornerDistance(again.grid, image.grid) < 1e-8);  // float32 in mm: 6e-8 of 50 mm
      }
}

TEST_CASE("Shares are written as whole steps, 0 and 1 exactly, in pieces of a megabyte", "[imaging][nifti]") {
  Image image(ImageGrid({300, 300, 7}, Mat3::Identity() * 1e-3, Vec3::Zero()));
  for (std::size_t v = 0; v < image.value.size(); ++v) image.value[v] = static_cast<float>(v % 1001) / 1000.0F;
  constexpr double step = 1.0 / 16384;
  for (const bool compressed : {false, true}) {
    const Image again = read(niftiFrom(image, NiftiType::Int16, compressed, step));
    float worst = 0;
    for (std::size_t v = 0; v < image.value.size(); ++v)
      worst = std::max(worst, std::abs(again.value[v] - image.value[v]));
    CHECK(worst <= 0.51F * static_cast<float>(step));
    CHECK(again.value[0] == 0);
    CHECK(again.value[1000] == 1);
  }
}

TEST_CASE("A side longer than 16 bits count is written as NIfTI-2", "[imaging][nifti]") {
  Image image(ImageGrid({40000, 1, 1}, Mat3::Identity() * 1e-3, Vec3(1, 2, 3)));
  image.value.back() = 5;
  const std::string bytes = niftiFrom(image, NiftiType::Int16, true);
  const Image again = read(bytes);
  CHECK(again.value == image.value);
  CHECK((again.grid.origin - image.grid.origin).norm() < 1e-12);
  CHECK(bytes.size() < 2000);
}

TEST_CASE("Several gzip members are one file", "[imaging][nifti]") {
  const std::string bytes = plain();
  const std::string halves = gzipped(bytes.substr(0, 400)) + gzipped(bytes.substr(400));
  CHECK(read(halves).value == sampleImage().value);
  CHECK_THAT(refusal([&] { read(halves.substr(0, halves.size() - 9)); }), Contains("cut short"));
}

TEST_CASE("The qform places an image that has no sform", "[imaging][nifti]") {
  std::string bytes = plain();
  put(bytes, 254, std::int16_t{0});
  CHECK(cornerDistance(read(bytes).grid, sampleImage().grid) < 1e-7);  // quaternions in float32

  std::string b = byHand();
  put(b, 252, std::int16_t{1});
  put(b, 268, 10.0F), put(b, 272, 20.0F), put(b, 276, 30.0F);
  for (const float qfac : {0.0F, 1.0F, -1.0F}) {
    put(b, 76, qfac);
    const Image image = read(b);
    CHECK((image.grid.worldOf(1, 1, 1) - Vec3(0.011, 0.022, qfac < 0 ? 0.027 : 0.033)).norm() < 1e-9);
    CHECK(image(1, 0, 1) == 5);
  }
}

TEST_CASE("Without sform and qform an image is refused, or taken as asked", "[imaging][nifti]") {
  CHECK_THAT(refusal([] { read(byHand()); }), Contains("--assume-ras"));
  NiftiOptions options;
  options.assume_ras = true;
  CHECK((read(byHand(), options).grid.worldOf(1, 1, 1) - Vec3(1e-3, 2e-3, 3e-3)).norm() < 1e-12);
}

TEST_CASE("A sform that spans no space is corrupt, and one that the qform contradicts is told of", "[imaging][nifti]") {
  std::string bytes = plain();
  for (std::size_t at = 296; at < 312; at += 4) put(bytes, at, 0.0F);  // srow_y
  CHECK_THAT(refusal([&] { read(bytes); }), Contains("sform is corrupt"));

  bytes = plain();
  std::string warning;
  NiftiOptions options;
  options.warn = [&](const std::string& text) { warning += text; };
  read(bytes, options);
  CHECK(warning.empty());
  put(bytes, 268, 40.0F);  // qoffset_x
  read(bytes, options);
  CHECK_THAT(warning, Contains("mm apart"));
}

TEST_CASE("Slope, intercept, units and byte order are followed", "[imaging][nifti]") {
  NiftiOptions ras;
  ras.assume_ras = true;
  std::string b = byHand();
  put(b, 112, 2.0F), put(b, 116, -1.0F);
  CHECK(read(b, ras)(1, 1, 1) == 13);
  put(b, 112, 0.0F);  // none
  CHECK(read(b, ras)(1, 1, 1) == 7);
  for (const auto& [code, unit] : {std::pair{1, 1.0}, {2, 1e-3}, {3, 1e-6}, {0, 1e-3}}) {
    b[123] = static_cast<char>(code | 8);  // with a unit of time, which is no matter
    CHECK(std::abs(read(b, ras).grid.spacing().z() / (3 * unit) - 1) < 1e-12);
  }
  b = byHand();
  const auto turn = [&](std::size_t at, std::size_t size) { std::reverse(&b[at], &b[at] + size); };
  turn(0, 4), turn(70, 2), turn(72, 2), turn(108, 4);
  for (std::size_t at = 40; at < 56; at += 2) turn(at, 2);
  for (std::size_t at = 76; at < 108; at += 4) turn(at, 4);
  for (std::size_t at = 352; at < b.size(); at += 2) turn(at, 2);
  CHECK(read(b, ras)(0, 1, 1) == 6);
}

TEST_CASE("What is no scan is refused with the reason, before memory is taken", "[imaging][nifti]") {
  const auto changed = [](std::size_t at, auto value) {
    std::string b = byHand();
    put(b, 252, std::int16_t{1});
    put(b, at, value);
    return refusal([&] { read(b); });
  };
  CHECK_THAT(changed(70, std::int16_t{128}), Contains("colour"));
  CHECK_THAT(changed(70, std::int16_t{32}), Contains("type 32"));
  CHECK_THAT(changed(72, std::int16_t{8}), Contains("8 bits"));
  CHECK_THAT(changed(42, std::int16_t{-2}), Contains("length of -2"));
  CHECK_THAT(changed(42, std::int16_t{32767}), Contains("too short for 131068 voxels"));
  CHECK_THAT(changed(40, std::int16_t{9}), Contains("9 dimensions"));
  CHECK_THAT(changed(108, 1e9F), Contains("too short"));
  CHECK_THAT(changed(108, std::nanf("")), Contains("too short"));
  CHECK_THAT(changed(80, 0.0F), Contains("qform is corrupt"));
  std::string four = byHand();
  put(four, 40, std::int16_t{4}), put(four, 48, std::int16_t{2});
  CHECK_THAT(refusal([&] { read(four); }), Contains("more than three dimensions"));
  CHECK_THAT(refusal([] { read(byHand().substr(0, 100)); }), Contains("only 100 bytes"));
  CHECK_THAT(refusal([] { read(std::string(400, 'x')); }), Contains("no NIfTI file"));
  std::string pair = byHand();
  std::memcpy(&pair[344], "ni1", 4);
  CHECK_THAT(refusal([&] { read(pair); }), Contains("pair of files"));
  // A compressed file that says more than deflate can expand it to.
  std::string huge = byHand();
  put(huge, 252, std::int16_t{1});
  for (const std::size_t at : {42U, 44U, 46U}) put(huge, at, std::int16_t{700});
  CHECK_THAT(refusal([&] { read(gzipped(huge)); }), Contains("too short for 343000000 voxels"));
}

TEST_CASE("A displacement field is written as ITK reads it", "[imaging][nifti]") {
  VectorImage field(ImageGrid({2, 1, 1}, Mat3::Identity() * 2e-3, Vec3::Zero()), Vec3f(1e-3F, 2e-3F, 3e-3F));
  const std::string b = niftiFrom(field, false);
  std::int16_t dim[8], intent = 0;
  std::memcpy(dim, &b[40], sizeof dim);
  std::memcpy(&intent, &b[68], sizeof intent);
  CHECK(dim[0] == 5);
  CHECK(dim[5] == 3);
  CHECK(intent == 1007);
  float component[6];
  std::memcpy(component, &b[352], sizeof component);
  CHECK(std::abs(component[0] + 1) < 1e-6);  // left: minus right, mm
  CHECK(std::abs(component[2] + 2) < 1e-6);
  CHECK(std::abs(component[4] - 3) < 1e-6);
}

TEST_CASE("An independent reader finds the same image", "[imaging][nifti][nibabel]") {
  if (std::system("python3 -c 'import nibabel' 2>/dev/null") != 0) {
    WARN("python3-nibabel is not installed: skipped");
    return;
  }
  TempFolder folder;
  const std::string file = folder.path("a.nii.gz");
  writeImage(file, sampleImage());
  const std::string script = "python3 -c \"import nibabel, numpy; i = nibabel.load('" + file +
                             "'); a = i.affine; w = a @ [4, 3, 2, 1]; print(i.get_fdata()[4, 3, 2]); "
                             "numpy.savetxt('" +
                             folder.path("w.txt") + "', [*w[:3], i.get_fdata()[1, 2, 1]])\"";
  REQUIRE(std::system((script + " > /dev/null").c_str()) == 0);
  std::ifstream in(folder.path("w.txt"));
  Vec3 w;
  double value = 0;
  in >> w[0] >> w[1] >> w[2] >> value;
  CHECK((1e-3 * w - sampleImage().grid.worldOf(4, 3, 2)).norm() < 1e-7);
  CHECK(value == static_cast<double>(sampleImage()(1, 2, 1)));
}

TEST_CASE("Values scaled by infinity are refused, and no number scales nothing", "[imaging][nifti]") {
  std::string bytes = plain();
  put(bytes, 112, std::numeric_limits<float>::quiet_NaN());
  CHECK(read(bytes).value == sampleImage().value);
  for (const std::size_t at : {112, 116}) {
    std::string damaged = plain();
    put(damaged, 112, 1.0F);
    put(damaged, at, std::numeric_limits<float>::infinity());
    CHECK_THAT(refusal([&] { read(damaged); }), Contains("a.nii: ") && Contains("scl_slope"));
  }
}
