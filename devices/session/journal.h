// journal.jsonl: what a session's device answered, in order, each line durable before the planner acts on it.
//
//   Every line is a JSON object; "n" counts lines from 0, and "crc" is the CRC-32 of all of the line before it, in 8 hexadecimal digits.
//   {"n":0,"palpate":"journal","schema":2,"version":"0.1.0","config":"<CRC-32 of config.yaml>","start":[x,y,z],
//    "machine":"Grbl 1.1h on /dev/ttyUSB0","object":"<SHA-256 of its mesh file>",…}    one line. "version", of the program that began the
//                                                          journal, and "object" may be missing
//   {"n":1,"move":[x,y,z],"pace":"probe","outcome":"contact","at":[x,y,z],"rest":[x,y,z],"events":[{"kind":"spurious_trigger","at":[x,y,z]}],…}
//                                                          with "datum":"way" or "datum":0 it is part of a visit to machine.datum:
//                                                          on the way there or back, or its touch 0
//   {"n":2,"resumed":{"contacts":[1],"offsets":[0.001],"directions":1},…}   taken up again; the contact of line 1 was touched 0.001 mm off
//                                                          its place, and shifts in one direction would have shown; with
//                                                          "datum":[[x,y,z],…] the touches of machine.datum then
//   {"n":3,"withdrawn":1,…}                                lines 1 to 2 do not count: a touch on travel that the session halted at, or what
//                                                          came after the last contact of a session that was interrupted
//   {"n":4,"end":{"planner":0.8,"oracle":120.5},…}         seconds; nothing follows but
//   {"n":5,"raised":{"config":"<CRC-32 of config.yaml>"},…}   the budget is a larger one now: the session goes on
// Positions are mm, in as many digits as read back to the same bits; "rest" is where the tool rests after the move.
//
// A last line that was not written to its end is dropped. All other damage is an error, with its line. When "schema" rises:
// config/README.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "devices/errors.h"
#include "devices/probe_device.h"

namespace palpate {

// The journal cannot be written or is in use: a fault like that of a device, after which the session can be resumed.
class JournalError : public DeviceError {
public:
    using DeviceError::DeviceError;
};

// What is in the file is not what was written to it, or another version of Palpate wrote it. The message begins with file:line.
class JournalDamaged : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

struct JournalHeader {
    std::string config;           // digest(): of the configuration that the session runs on
    Point start = Point::Zero();  // mm: where the tool was
    std::string machine;
    std::string version{};        // of the program; empty: not known
    std::string object_sha256{};  // of the file that describes the object; empty: there is none

    friend bool operator==(const JournalHeader&, const JournalHeader&) = default;
};

// That a move is part of a visit to the datum (drift_datum.h).
struct DatumMark {
    std::optional<std::uint64_t> touch{};  // which of its touches; none: the way there or back

    friend bool operator==(const DatumMark&, const DatumMark&) = default;
};

// A move that was asked of the device, and its answer.
struct JournalMove {
    Point target = Point::Zero();
    Pace pace = Pace::travel;
    MoveResult result;
    Point rest = Point::Zero();
    std::uint64_t line = 0;
    std::optional<DatumMark> datum{};

    friend bool operator==(const JournalMove&, const JournalMove&) = default;
};

// The known places that a resumed session touched again.
struct JournalResumption {
    std::vector<std::uint64_t> contacts{};  // their lines
    std::vector<double> offsets_mm{};       // along S's normals, between then and now
    int directions = 0;                     // independent ones in which a shift would have shown, 0 to 3
    bool after_miss = false;                // the session itself did, as the probe had missed a touch
    std::vector<Point> datum{};             // mm: where the touches of the datum were, all of them; empty: none, or not touched before
    std::uint64_t line = 0;

    friend bool operator==(const JournalResumption&, const JournalResumption&) = default;
};

struct JournalEnd {
    double planner_seconds = 0.0;
    double oracle_seconds = 0.0;

    friend bool operator==(const JournalEnd&, const JournalEnd&) = default;
};

struct Journal {
    JournalHeader header;
    std::vector<JournalMove> moves{};  // those that count
    std::vector<JournalResumption> resumptions{};
    std::optional<JournalEnd> end{};
    std::vector<std::string> raised{};  // digest(): of the configurations with a larger budget that it went on with
    bool is_raised_last = false;        // nothing was done since
    std::uint64_t lines = 0;            // whole ones
    std::uint64_t bytes = 0;            // of them
    std::uint64_t dropped_bytes = 0;    // of a last line that is torn

    // Whether it goes on with a configuration of that digest().
    [[nodiscard]] bool fits(const std::string& config_digest) const;
    // Where the tool rests after all of it.
    [[nodiscard]] const Point& last_rest() const { return moves.empty() ? header.start : moves.back().rest; }
    // The last probe, of the first `count` moves, that found a place free (within `tolerance`, mm) which was touched then: it missed S.
    [[nodiscard]] std::optional<std::size_t> last_passed(const Point& touched, double tolerance, std::size_t count) const;
    // Where the tool was before a move.
    [[nodiscard]] const Point& rest_before(std::size_t move) const { return move == 0 ? header.start : moves[move - 1].rest; }
    // So many moves come up to and with the last that something was touched in: nothing but a touch shows that the probe works, and what
    // was found free since then is in doubt once a session was interrupted. Visits to the datum are made again, too.
    [[nodiscard]] std::size_t confirmed_moves() const;
};

// CRC-32 in 8 hexadecimal digits.
[[nodiscard]] std::string digest(const std::string& text);

// Throws JournalDamaged, and JournalError if it cannot be read. Linear time.
[[nodiscard]] Journal read_journal(const std::filesystem::path& file);
[[nodiscard]] Journal parse_journal(const std::string& text, const std::string& name);

// What was cut off a damaged journal.
struct JournalCut {
    std::filesystem::path kept;         // the damaged one, as it was
    std::string damage;                 // the first, with its line
    std::uint64_t lines = 0;            // those that are left
    std::uint64_t lost = 0;             // those that are not, the damaged one included
    std::vector<std::string> raised{};  // digest(): of configurations with a larger budget that whole lines of those tell of
};

// Leaves of a damaged journal what is before the first damage, and keeps the whole beside it. Nothing, if it is not damaged. Throws
// JournalDamaged if its first line is, and JournalError if that cannot be written.
[[nodiscard]] std::optional<JournalCut> salvage_journal(const std::filesystem::path& file);

// Appends; every call returns when the line is on the disk. One process at a time.
class JournalWriter {
public:
    // A new one. Throws JournalError if there is one already, another process has it, or it cannot be made.
    static JournalWriter create(const std::filesystem::path& file, const JournalHeader& header);
    // One that is there, locked, so that what read() finds stays true. Throws JournalError if another process has it, or it cannot be
    // opened.
    explicit JournalWriter(const std::filesystem::path& file);
    ~JournalWriter();
    JournalWriter(JournalWriter&& other) noexcept;
    JournalWriter(const JournalWriter&) = delete;
    JournalWriter& operator=(const JournalWriter&) = delete;
    JournalWriter& operator=(JournalWriter&&) = delete;

    // Reads the file and goes on after its whole lines: a torn one is cut off.
    [[nodiscard]] Journal read();

    // Each throws JournalError if the line cannot be made durable (the disk is full, say, or the file is not there any more); the file then
    // ends with the line before, and nothing more is written. An answer with a number that is not finite throws BadAnswer, and nothing is
    // written. Returns the number of the line.
    std::uint64_t append(const JournalMove& move);
    std::uint64_t append(const JournalResumption& resumption);
    void append_withdrawn(std::uint64_t first_line);
    void append(const JournalEnd& end);
    void append_raised(const std::string& config_digest);

private:
    JournalWriter(const std::filesystem::path& file, int more_flags);
    void append_line(std::string line);
    void require_in_place();
    [[noreturn]] void fail(const std::string& what, int error) const;

    std::filesystem::path path_;
    int file_ = -1;
    std::uint64_t lines_ = 0;
    std::uint64_t bytes_ = 0;
    bool is_broken_ = false;
};

}  // namespace palpate
