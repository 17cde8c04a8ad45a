#pragma once

#include <string>

#include "realtime/recording/recording.h"

namespace palpate {

/// A recording as text, one change per line, numbers in their shortest exact form:
///   palpate-recording 3
///   scene liver
///   model 0123456789abcdef
///   rate_hz 500
///   0 tool 0 0 0.1  1 0 0 0              position m, quaternion w x y z
///   0 hand 1 0.02 0 0.1  1 0 0 0         likewise of a further tool, by its number from 1
///   3 opening 0 0.004                    m, of the jaws of a tool, by its number from 0
///   12 pull 411 0.01 0 0.12              skin vertex, target m
///   15 release
///   20 friction 0.3
///   20 gravity 0 0 -9.81                 m/s^2
///   20 force 411 0 0 0.1                 skin vertex, N; -1: all end
///   20 pin 411 0.01 0 0.12               skin vertex, m
///   20 unpin 411                         -1: all
///   20 region 0 0 0 0.002                boundary, m; -1: all
///   21 material 0 neo-hookean young 3000 poisson 0.49 barrier_strength 0 barrier_J0 0.5 density 1060
///   21 material 0 ogden mu 2 1000 500 alpha 2 2 -2 D1 4e-5 barrier_strength 0 ...    lists after their length
///      ... density 1060 relaxation 4 0.3 0.1 0.2 2    at the end, of one that relaxes
///   30 reset
///   40 mark 2 0.01 0.02 0.08             how hard, 1 .. 3, and where a trainee says that a lump is, m
///   41 unmark
///   44 submit                            from here on a replay shows the lumps
///   50 place 17 -1 -1 -1                 where a cloud that follows the tool goes, by the number of each tool's centre
///   end 500                              ticks of the run; missing: cut off
/// The scene's name is written without line ends and other control characters, which would end its line.
/// Write it with writeWholeFile (io/output_file.h), so that an earlier recording stays until this one is whole.
std::string toText(const Recording& recording);

/// Throws InputError naming file and line of what is damaged or missing.
Recording readRecording(const std::string& file);

}  // namespace palpate
