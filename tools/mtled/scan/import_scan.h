#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate::tools {

struct ImportScanOptions {
  std::string scan;                // NIfTI
  std::string mask;                // NIfTI; "" where labels are given
  std::string labels;              // NIfTI
  std::vector<int> label;          // the labels that are the organ
  int classes = 3;                 // of tissue; 0: all is one tissue
  std::string fluid = "dark";      // "dark", "bright" or "none": the class that is fluid (dark on T1, bright on T2)
  std::string electrodes;          // CSV, .fcsv or .mrk.json; "" for none
  std::string unit = "mm", frame;  // of the electrodes' CSV; frame "ras" or "lps"
  bool skull = false;              // it slides in a rigid shell around it, open over the electrodes
  std::vector<std::string>
      opened;                    // "X,Y,Z,R", mm in `frame` (RAS where that is ""): balls where the skull is open, too
  std::vector<std::string> fix;  // likewise: where the organ is held; none: at its lowest twentieth
  double spacing_mm = 0;         // between nodes; 0: for `nodes`
  int nodes = 3000;              // wanted, where no spacing is given
  double smoothing_mm = 0;       // of the mask's border; 0: 0.35 of the spacing
  bool assume_ras = false;
  std::string out;   // folder; "": out/<scan's name>
  bool open = true;  // open the scene, which draws the pictures and keeps the set-up; and say what was done
};

/// From a scan to a case: a folder with scene.toml, surface.obj, the tissue's memberships (csf.nii.gz, tissue_2.nii.gz,
/// ...), mask.nii.gz, a copy of the electrodes, preview.png, organ.png and report.json. `palpate CASE/scene.toml`
/// touches it, `mtled solve CASE` computes the shift, `mtled warp CASE --image I.nii.gz` warps an image by that.
/// @return 0, or 1 where it was interrupted. The folder gets its files all at once, at the end: nothing is left behind
/// of an import that was interrupted or refused.
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int importScan(const ImportScanOptions& options);

/// Whether mtled import takes the file for a scan: .nii or .nii.gz.
bool isScan(const std::string& file);

}  // namespace palpate::tools
