#pragma once

#include <functional>
#include <vector>

#include "imaging/image.h"

namespace palpate {

struct FuzzyOptions {
  int classes = 3;      // 2 .. 6
  int bias_degree = 3;  // of the polynomial that the bias field is; 0: no bias is looked for
  int max_iterations = 60;
};

/// Tissue classes without segmentation: to what degree each voxel belongs to each class.
struct FuzzyClasses {
  std::vector<double> centre;     // (class_count) intensity of each class without bias, ascending
  std::vector<Image> membership;  // (class_count) 0 .. 1, with the sum 1 in the mask; 0 outside
  Image bias;                     // factor that the scan has too much; 1 on average in the mask, 1 outside
  int iterations = 0;
};

/// Fuzzy c-means (Bezdek 1981) of the intensities in a mask, with m = 2, together with a multiplicative bias field as
/// Pham and Prince 1999 and Ahmed et al. 2002 have it:
///
///   u_ik = 1 / sum_j (|y_k - v_i| / |y_k - v_j|)^2,   1 beyond the outermost centres
///   v_i  = sum_k u_ik^2 y_k / sum_k u_ik^2,           y_k = x_k - b_k
///
/// x are logarithms of the intensities and b a polynomial of zero mean, fitted with weights w_k = sum_i u_ik^2 to
/// x_k - sum_i u_ik^2 v_i / w_k, in turn with u and v, on at most 60,000 voxels of the mask, evenly chosen. Memberships
/// are then those of the intensities themselves, less the bias: noise is as large for dark tissue as for bright, which
/// their logarithms are not. Before all that each voxel is averaged with those around it in the mask that are like it
/// (Tomasi and Manduchi 1998, by as much as the scan is noisy; what is alike is judged on a first such mean, Petschnigg
/// et al. 2004): noise puts many voxels between two centres, where memberships are least sure.
/// Starts from quantiles of a histogram: no random numbers, equal output for equal input.
///
/// @param progress  told the share that is done; may throw
/// Throws InputError where the mask is empty or the intensities in it are fewer than the classes.
/// Test: imaging/fuzzy_c_means_test.cpp
FuzzyClasses fuzzyCMeans(const Image& scan, const Mask& mask, const FuzzyOptions& options = {},
                         const std::function<void(double)>& progress = {});

/// Memberships of one value in classes with these centres (ascending). @param u  (class_count)
void fuzzyMemberships(double y, const std::vector<double>& centre, double* u);

}  // namespace palpate
