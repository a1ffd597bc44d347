#include "tools/session_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <system_error>
#include <utility>

#include "devices/errors.h"
#include "devices/session/journal.h"
#include "tools/session_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// The lock on it, which ends with this process.
int lock_of(const fs::path& folder) {
    const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) throw OutputError(fmt::format("{}: {}", folder.string(), std::generic_category().message(errno)));
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) return file;
    ::close(file);
    throw OutputError(fmt::format("{}: another process works in it; wait for its end, or choose another folder", folder.string()));
}

void require_no_journal(const fs::path& folder) {
    std::error_code ignored;
    const fs::path journal = folder / kJournalFile;
    if (!fs::exists(journal, ignored) || (fs::is_regular_file(journal, ignored) && fs::file_size(journal, ignored) == 0)) return;
    throw OutputError(
        fmt::format("{}: holds the session of a machine ({}), which is never overwritten; go on with it: palpate resume {}; or choose "
                    "another folder",
                    folder.string(), kJournalFile, shell_word(folder.string())));
}

void require_no_input(const fs::path& folder, const std::vector<fs::path>& inputs) {
    std::error_code ignored;
    for (const char* file : kSessionFiles) {
        for (const fs::path& input : inputs) {
            if (!fs::equivalent(input, folder / file, ignored)) continue;
            throw OutputError(fmt::format("{}: is read by this run, which would overwrite it with its own {}; choose another folder",
                                          input.string(), file));
        }
    }
}

}  // namespace

fs::path folder_of(const fs::path& folder_or_journal) {
    const bool is_journal = folder_or_journal.filename() == kJournalFile && !fs::is_directory(folder_or_journal);
    fs::path folder = is_journal ? folder_or_journal.parent_path() : folder_or_journal;
    return folder.empty() ? fs::path(".") : folder;
}

SessionFolder SessionFolder::begin(const fs::path& folder, const std::vector<fs::path>& inputs,
                                   const std::function<bool(std::string_view)>& may_replace) {
    std::error_code error;
    std::vector<fs::path> made;
    for (fs::path missing = fs::absolute(folder).lexically_normal(); !fs::exists(missing, error); missing = missing.parent_path()) {
        if (missing.has_filename()) made.push_back(missing);
    }
    fs::create_directories(folder, error);
    if (error || !fs::is_directory(folder)) {
        throw OutputError(fmt::format("{}: cannot make this folder: {}", folder.string(), error ? error.message() : "a file is there"));
    }
    SessionFolder begun(folder, std::move(made), lock_of(folder));
    require_no_journal(folder);
    require_no_input(folder, inputs);
    for (const std::string_view file : kSessionFiles) {
        if (file == kJournalFile || !fs::exists(folder / file, error) || may_replace(file)) continue;
        throw OutputError(fmt::format("{}: holds a session already ({}); choose another folder, or (simulate) give --force to replace it",
                                      folder.string(), file));
    }
    fs::remove(folder / kJournalFile, error);  // empty, if it is there: nothing began
    write_file(folder / "palpate.trial", "");
    fs::remove(folder / "palpate.trial", error);
    return begun;
}

SessionFolder SessionFolder::open(const fs::path& folder_or_journal) {
    const fs::path folder = folder_of(folder_or_journal);
    std::error_code error;
    if (!fs::is_regular_file(folder / kJournalFile, error)) {
        throw SetupError(
            fmt::format("{}: holds no {} that is a file; only what `palpate probe` began can be resumed", folder.string(), kJournalFile));
    }
    return {folder, {}, lock_of(folder)};
}

SessionFolder::SessionFolder(fs::path path, std::vector<fs::path> made, int lock)
    : path_(std::move(path)), made_(std::move(made)), lock_(lock) {}

SessionFolder::~SessionFolder() {
    if (lock_ < 0) return;
    std::error_code ignored;
    for (const fs::path& folder : made_) fs::remove(folder, ignored);  // which an empty one alone allows
    ::close(lock_);
}

SessionFolder::SessionFolder(SessionFolder&& other) noexcept
    : path_(std::move(other.path_)), made_(std::move(other.made_)), lock_(std::exchange(other.lock_, -1)) {}

}  // namespace palpate
