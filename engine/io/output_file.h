#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Writes a file whole or not at all: into FILE.part beside it, which then takes its place, so that who
/// reads it never sees a half. Throws std::runtime_error with the file and the system's reason (folder
/// missing or read-only, disk full); what stood there before is then untouched.
void writeWholeFile(const std::string& path, std::string_view bytes);

/// Throws std::runtime_error "can't write FILE: reason; advice" for an errno (0: reason unknown).
[[noreturn]] void failWriting(const std::string& path, int error, const std::string& advice = "choose another place");

/// For the end of a program: throws as failWriting does where something that it printed has not arrived.
void finishStandardOutput();

}  // namespace palpate
