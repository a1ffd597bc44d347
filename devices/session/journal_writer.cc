// Writing journal.jsonl; reading is journal_reader.cc.
//
// Lines are put together by hand, although nlohmann-json reads them: it cannot be told how to write a number. It has 977.0 for 977, and one
// or more digits too many in 0.04 % of random doubles within a metre.
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <iterator>

#include "devices/errors.h"
#include "devices/session/internal/journal_words.h"
#include "devices/session/journal.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
constexpr mode_t kMode = 0644;

std::string number(double x) {
    if (!std::isfinite(x)) throw BadAnswer("an answer with a number that is not finite is not written into the journal");
    return number_text(x);
}

template <typename Value, typename Text>
std::vector<std::string> texts_of(const std::vector<Value>& values, const Text& text) {
    std::vector<std::string> texts;
    std::ranges::transform(values, std::back_inserter(texts), text);
    return texts;
}

std::string place(const Point& p) { return fmt::format("[{},{},{}]", number(p.x()), number(p.y()), number(p.z())); }

// A JSON string; the texts are ours or a controller's, and what is not printable ASCII in them is of no use.
std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        result += c >= ' ' && c <= '~' ? c : '?';
    }
    return result + '"';
}

// A new file is there after a crash only if its folder says so.
void sync_folder(const fs::path& file) {
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    const int handle = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (handle < 0) return;
    ::fsync(handle);
    ::close(handle);
}

}  // namespace

std::string digest(const std::string& text) {
    const uLong crc = ::crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size());
    return fmt::format("{:08x}", crc);
}

JournalWriter::JournalWriter(const fs::path& file) : JournalWriter(file, 0) {}

JournalWriter::JournalWriter(const fs::path& file, int more_flags) : path_(file) {
    file_ = ::open(path_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC | more_flags, kMode);
    if (file_ < 0) fail("cannot be opened", errno);
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
        ::close(file_);
        throw JournalError(fmt::format("{}: another process runs this session; wait for its end, or stop it", path_.string()));
    }
}

JournalWriter::JournalWriter(JournalWriter&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      lines_(other.lines_),
      bytes_(other.bytes_),
      is_broken_(other.is_broken_) {}

JournalWriter::~JournalWriter() {
    if (file_ >= 0) ::close(file_);
}

JournalWriter JournalWriter::create(const fs::path& file, const JournalHeader& header) {
    JournalWriter writer(file, O_CREAT);
    std::error_code error;
    if (fs::file_size(file, error) > 0 || error) {
        throw JournalError(fmt::format("{}: holds a session already; choose another folder, or resume it", file.string()));
    }
    try {
        const auto known = [](const char* key, const std::string& text) {
            return text.empty() ? "" : fmt::format(R"(,"{}":{})", key, quoted(text));
        };
        writer.append_line(fmt::format(R"("palpate":"journal","schema":{}{},"config":{},"start":{},"machine":{}{})", kJournalSchema,
                                       known("version", header.version), quoted(header.config), place(header.start), quoted(header.machine),
                                       known("object", header.object_sha256)));
    } catch (...) {
        fs::remove(file, error);  // nothing began
        throw;
    }
    sync_folder(file);
    return writer;
}

Journal JournalWriter::read() {
    Journal journal = read_journal(path_);
    lines_ = journal.lines;
    bytes_ = journal.bytes;
    if (journal.dropped_bytes > 0 && ::ftruncate(file_, static_cast<off_t>(bytes_)) != 0)
        fail("its torn last line cannot be cut off", errno);
    return journal;
}

std::uint64_t JournalWriter::append(const JournalMove& move) {
    std::string line = fmt::format(R"("move":{},"pace":"{}","outcome":"{}","at":{},"rest":{})", place(move.target), word_of(move.pace),
                                   word_of(move.result.outcome), place(move.result.position), place(move.rest));
    if (move.datum) {
        line += move.datum->touch ? fmt::format(R"(,"datum":{})", *move.datum->touch) : fmt::format(R"(,"datum":"{}")", kDatumWay);
    }
    if (!move.result.events.empty()) {
        const auto text = [](const DeviceEvent& event) {
            return fmt::format(R"({{"kind":"{}","at":{}}})", word_of(event.kind), place(event.position));
        };
        line += fmt::format(R"(,"events":[{}])", fmt::join(texts_of(move.result.events, text), ","));
    }
    append_line(std::move(line));
    return lines_ - 1;
}

std::uint64_t JournalWriter::append(const JournalResumption& resumption) {
    const std::string datum =
        resumption.datum.empty() ? "" : fmt::format(R"(,"datum":[{}])", fmt::join(texts_of(resumption.datum, place), ","));
    append_line(fmt::format(R"("resumed":{{"contacts":[{}],"offsets":[{}],"directions":{}{}{}}})", fmt::join(resumption.contacts, ","),
                            fmt::join(texts_of(resumption.offsets_mm, number), ","), resumption.directions,
                            resumption.after_miss ? R"(,"after_miss":true)" : "", datum));
    return lines_ - 1;
}

void JournalWriter::append_withdrawn(std::uint64_t first_line) { append_line(fmt::format(R"("withdrawn":{})", first_line)); }

void JournalWriter::append(const JournalEnd& end) {
    append_line(fmt::format(R"("end":{{"planner":{},"oracle":{}}})", number(end.planner_seconds), number(end.oracle_seconds)));
}

void JournalWriter::append_raised(const std::string& config_digest) {
    append_line(fmt::format(R"("raised":{{"config":{}}})", quoted(config_digest)));
}

void JournalWriter::append_line(std::string line) {
    if (is_broken_) {
        throw JournalError(fmt::format("{}: could not be written before; nothing more is written: resume the session", path_.string()));
    }
    line = fmt::format(R"({{"n":{},{})", lines_, line);
    line += fmt::format(",\"crc\":\"{}\"}}\n", digest(line));
    std::size_t written = 0;
    int error = 0;
    while (written < line.size() && error == 0) {
        const ssize_t count = ::write(file_, line.data() + written, line.size() - written);
        if (count > 0) written += static_cast<std::size_t>(count);
        if (count == 0) error = ENOSPC;
        if (count < 0 && errno != EINTR) error = errno;
    }
    if (error == 0 && ::fdatasync(file_) != 0) error = errno;
    if (error == 0) require_in_place();
    if (error != 0) {
        is_broken_ = true;
        // A journal that ends with a whole line can be resumed as it is; if that fails too, the next reader drops the torn one.
        if (::ftruncate(file_, static_cast<off_t>(bytes_)) != 0) fail("cannot be written, and its last line is torn", error);
        fail("cannot be written", error);
    }
    ++lines_;
    bytes_ += line.size();
}

// A folder that was moved or deleted takes its journal along: what is written would be nowhere, or not where it is looked for.
void JournalWriter::require_in_place() {
    struct stat here {};
    struct stat there {};
    if (::fstat(file_, &here) != 0 || (::stat(path_.c_str(), &there) == 0 && here.st_dev == there.st_dev && here.st_ino == there.st_ino))
        return;
    is_broken_ = true;
    throw JournalError(fmt::format("{}: {}; nothing moves after that", path_.string(),
                                   here.st_nlink == 0
                                       ? "was deleted while the session ran, and what was touched is lost with it: begin a new one"
                                       : "was moved while the session ran: it is whole where it is now, resume it there"));
}

void JournalWriter::fail(const std::string& what, int error) const {
    throw JournalError(fmt::format("{}: {}: {}; make room or give the right to write, then resume", path_.string(), what, reason(error)));
}

}  // namespace palpate
