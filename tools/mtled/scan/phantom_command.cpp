#include "mtled/scan/phantom_command.h"

#include <filesystem>
#include <iostream>

#include "io/image_file.h"
#include "io/output_file.h"
#include "io/result_csv.h"
#include "mtled/run/progress.h"

namespace palpate::tools {

void writeForImport(const Phantom& phantom, const std::string& folder) {
  writeImage(folder + "/scan.nii.gz", phantom.scan);
  writeImage(folder + "/mask.nii.gz", phantom.mask);
  ResultCsv csv(folder + "/electrodes.csv", {"x0", "y0", "z0", "x", "y", "z"});
  for (std::size_t k = 0; k < phantom.before.size(); ++k) {
    const Vec3 before = phantom.before[k] / mm, after = phantom.after[k] / mm;
    csv.add(std::vector<double>{before.x(), before.y(), before.z(), after.x(), after.y(), after.z()});
  }
  csv.finish();
}

int phantomCommand(const PhantomCommandOptions& options) {
  makeFolder(options.out);
  const auto file = [&](const char* name) { return (std::filesystem::path(options.out) / name).string(); };
  ProgressLine progress("phantom");
  progress.show(0, "tissue");
  const Phantom phantom = makePhantom(options.phantom);
  progress.show(0.7, "writing");
  writeForImport(phantom, options.out);
  writeImage(file("labels.nii.gz"), phantom.labels, NiftiType::UInt8);
  const char* const names[] = {"true_fluid.nii.gz", "true_grey.nii.gz", "true_white.nii.gz"};
  for (std::size_t t = 0; t < 3; ++t) writeImage(file(names[t]), phantom.fraction[t]);
  const auto& size = phantom.scan.grid.size;
  std::cout << "phantom: " << size[0] << " x " << size[1] << " x " << size[2] << " voxels, " << phantom.before.size()
            << " electrodes, in " << options.out << "\nnext     mtled import " << file("scan.nii.gz") << " --mask "
            << file("mask.nii.gz") << " --electrodes " << file("electrodes.csv") << " --frame ras --out CASE"
            << std::endl;
  return 0;
}

}  // namespace palpate::tools
