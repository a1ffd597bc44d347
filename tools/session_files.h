// What a session leaves (planner/DESIGN.md, "Session folder"): config.yaml, mesh.ply, touches.csv, summary.json, picture.png; on a machine
// journal.jsonl.
#pragma once

#include <filesystem>
#include <string>

#include "planner/probe_surface.h"

namespace palpate {

inline constexpr const char* kConfigFile = "config.yaml";
inline constexpr const char* kJournalFile = "journal.jsonl";
inline constexpr const char* kMeshFile = "mesh.ply";
inline constexpr const char* kPictureFile = "picture.png";

// A folder or file that cannot be used. The message names it and says what to do.
class OutputError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// Makes the folder and tries it, before a run that would otherwise be lost; a session that is there stays as it is. Throws
// OutputError if it holds a session already and not `force`, or cannot be made or written.
void prepare_session_folder(const std::filesystem::path& folder, bool force);

// Takes away what a session on a machine left that ended before its journal was begun: it is in nobody's way.
void remove_unbegun_session(const std::filesystem::path& folder);

// Writes a whole file, or leaves what was there as it was. Throws OutputError.
void write_file(const std::filesystem::path& file, const std::string& content);

// ASCII PLY with double coordinates, shortest digits that read back to the same bits.
[[nodiscard]] std::string to_ply(const TriangleMesh& mesh);

// One line per contact, in order: touch, x, y, z (mm), from_x, from_y, from_z (mm: where the probe started), role
// (crossing, seed, seed_facet, refinement, repair), sample (its index, or nothing).
[[nodiscard]] std::string to_csv(const std::vector<Touch>& touches);

}  // namespace palpate
