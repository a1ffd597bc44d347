// What a result is from: which program, which configuration, which object. Nothing of it depends on where or when the program ran.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/session_config.h"
#include "planner/certificate.h"

namespace palpate {

// Of what a session's folder holds. The program is program_version().
struct Provenance {
    std::string config_digest;    // digest() of config.yaml
    std::string shape{};          // the object, if the configuration names one: the kind of a shape, or
    std::string mesh{};           // a mesh file, as config.yaml names it,
    std::string object_sha256{};  // and its content; empty: not known
};

// Of a session whose configuration is kept in `folder`.
[[nodiscard]] Provenance provenance_of(const SessionConfig& config, const std::filesystem::path& folder, std::string config_digest,
                                       std::string object_sha256);

// SHA-256 of the mesh file that a configuration names; empty if it names none, or one that cannot be read.
[[nodiscard]] std::string object_sha256(const SessionConfig& config);
// In hexadecimal digits, as sha256sum prints it; empty if the file cannot be read.
[[nodiscard]] std::string file_sha256(const std::filesystem::path& file);

// What mesh.ply says of itself, a line each: where it is from, and that it is incomplete or refuted if it is.
[[nodiscard]] std::vector<std::string> mesh_comments(const Provenance& provenance, const Certificate& certificate);

}  // namespace palpate
