// What a session leaves (planner/DESIGN.md, "Session folder"): config.yaml, mesh.ply, surface.ply, touches.csv, summary.json, picture.png;
// on a machine journal.jsonl; earlier.csv if it went on from another.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "planner/probe_surface.h"

namespace palpate {

inline constexpr const char* kConfigFile = "config.yaml";
inline constexpr const char* kJournalFile = "journal.jsonl";
inline constexpr const char* kMeshFile = "mesh.ply";
inline constexpr const char* kToolMeshFile = "mesh_tool.ply";
inline constexpr const char* kSurfaceFile = "surface.ply";
inline constexpr const char* kPictureFile = "picture.png";
inline constexpr const char* kTouchesFile = "touches.csv";
inline constexpr const char* kSummaryFile = "summary.json";
// In a session that goes on from another: the touches of that.
inline constexpr const char* kEarlierFile = "earlier.csv";
inline constexpr std::array<const char*, 9> kSessionFiles = {kEarlierFile, kConfigFile,  kJournalFile, kMeshFile,   kToolMeshFile,
                                                             kSurfaceFile, kTouchesFile, kSummaryFile, kPictureFile};

// A folder or file that cannot be used. The message names it and says what to do.
class OutputError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// Takes away what a session on a machine left that ended before its journal was begun: it is in nobody's way.
void remove_unbegun_session(const std::filesystem::path& folder);

// A word as a shell takes it, for hints that can be copied.
[[nodiscard]] std::string shell_word(const std::string& word);

// The whole file; empty if it cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

// A file that a session left. Throws OutputError if it is not there.
[[nodiscard]] std::filesystem::path file_of_session(const std::filesystem::path& folder, const char* name);

// Throws OutputError if the file is there and `force` does not say that it may be replaced.
void refuse_to_replace(const std::filesystem::path& file, bool force);

// Writes a whole file, or leaves what was there as it was. Throws OutputError with the system's reason.
void write_file(const std::filesystem::path& file, const std::string& content);

// ASCII PLY with double coordinates, shortest digits that read back to the same bits. REQUIRES: each comment is one line.
[[nodiscard]] std::string to_ply(const TriangleMesh& mesh, const std::vector<std::string>& comments = {});

// One line per contact, in order, with the columns of planner/DESIGN.md, "Session folder".
[[nodiscard]] std::string to_csv(const std::vector<Touch>& touches);

}  // namespace palpate
