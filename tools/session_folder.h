// A session's folder while a process works in it: nobody else does, and what was there stays.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

namespace palpate {

// The folder that is meant by itself or by its journal.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& folder_or_journal);

class SessionFolder {
public:
    // Makes the folder if it is not there and tries it, before a run that would otherwise be lost. Files of a session may be there as far
    // as `may_replace` says so; a journal never is replaced, unless it is empty, nor is one of `inputs`. Throws OutputError that names what
    // is in the way.
    static SessionFolder begin(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& inputs,
                               const std::function<bool(std::string_view file)>& may_replace);
    // That of a session that was begun, given by the folder or by its journal. Throws SetupError if there is none, JournalError if another
    // process runs it.
    static SessionFolder open(const std::filesystem::path& folder_or_journal);
    // Gives the folder back, and takes away what this made of folders if nothing is in them.
    ~SessionFolder();
    SessionFolder(SessionFolder&& other) noexcept;
    SessionFolder(const SessionFolder&) = delete;
    SessionFolder& operator=(const SessionFolder&) = delete;
    SessionFolder& operator=(SessionFolder&&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    SessionFolder(std::filesystem::path path, std::vector<std::filesystem::path> made, int lock);

    std::filesystem::path path_;
    std::vector<std::filesystem::path> made_;  // folders that were not there, the innermost first
    int lock_ = -1;                            // an open file, whose lock ends with the process, however that ends
};

}  // namespace palpate
