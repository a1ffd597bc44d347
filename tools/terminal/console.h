// Standard error, which nobody ever waits for: a terminal that is held, a full pipe or a reader that is gone lose lines, not time.
//
// The last line may be a status that rewrites itself. Text never mixes with it: it is taken away before, and drawn again after.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace palpate {

class Console {
public:
    // A thread of its own writes to `file_descriptor`, which must stay open.
    // `lost_lines` is what is said of so many lines that nobody took.
    using LostLines = std::string (*)(std::uint64_t count);
    explicit Console(int file_descriptor, LostLines lost_lines = say_lost);
    static std::string say_lost(std::uint64_t count);
    // Gives the far end a moment to take what is left.
    ~Console();
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;
    Console(Console&&) = delete;
    Console& operator=(Console&&) = delete;

    // Never waits. What the far end does not take in time is dropped, by whole calls, and how many lines that were is said when it takes
    // text again.
    void write(std::string_view text);
    // The status from now on, or none: one line without its end. Only the newest is drawn.
    void set_status(std::string line);
    // Until all is written, or for `patience` at most. Whether all is.
    bool flush(std::chrono::milliseconds patience);
    // Nobody will ever read what is written.
    [[nodiscard]] bool is_dead() const;

private:
    struct Shared;
    std::shared_ptr<Shared> shared_;  // the thread may outlive this, waiting for a terminal that is held
};

// A stream whose text goes to a console, line by line or when it is flushed.
class ConsoleStream : public std::ostream {
public:
    explicit ConsoleStream(Console& console) : std::ostream(nullptr), buffer_(console) { rdbuf(&buffer_); }

    [[nodiscard]] std::streambuf* buffer() { return &buffer_; }

private:
    class Buffer : public std::streambuf {
    public:
        explicit Buffer(Console& console) : console_(console) {}

    protected:
        int_type overflow(int_type c) override;
        std::streamsize xsputn(const char* text, std::streamsize count) override;
        int sync() override;

    private:
        Console& console_;
        std::string line_;
    };
    Buffer buffer_;
};

}  // namespace palpate
