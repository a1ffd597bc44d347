// Words and numbers of a text, with the line that they stand on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

// Lines end with LF, CR LF or CR. A byte order mark at the beginning is read over. Numbers are independent of the locale.
class TextScanner {
public:
    struct Rules {
        bool comments = false;   // from # to the end of the line
        bool continued = false;  // a backslash before the end of a line joins the next one to it
    };

    explicit TextScanner(std::string_view text) : TextScanner(text, Rules{}) {}
    TextScanner(std::string_view text, Rules rules);

    // The next word, on whatever line; empty at the end of the text.
    std::string_view word();
    // The next word on the present line; empty at its end.
    std::string_view word_on_line();
    [[nodiscard]] bool at_line_end();
    void skip_line();             // what is left of it
    void skip_line_as_written();  // the same, but no backslash continues it

    // What a word says. Throw ObjectError, naming line, word and what was expected, if that is no number up to kLargestCoordinate, or no
    // whole number of 64 bits.
    [[nodiscard]] double coordinate(std::string_view word) const;
    [[nodiscard]] std::int64_t whole(std::string_view word, std::string_view expected) const;
    [[nodiscard]] std::size_t count(std::string_view word, std::string_view expected) const;  // a whole number that is not negative

    [[nodiscard]] std::size_t line() const { return word_line_; }   // of the last word, from 1
    [[nodiscard]] std::size_t offset() const { return position_; }  // bytes before what comes next

    // Throw ObjectError: "line 7: 'abc' where a coordinate was expected". An empty word is the end of the line or of the text.
    [[noreturn]] void refuse_word(std::string_view word, std::string_view expected) const;
    [[noreturn]] void refuse(const std::string& what) const;

private:
    [[nodiscard]] std::size_t line_end_at(std::size_t position) const;  // bytes of the end of line there, 0 if there is none
    void skip_blanks();
    void end_line(std::size_t bytes);

    std::string_view text_;
    Rules rules_;
    std::size_t position_ = 0;
    std::size_t line_ = 1;       // of position_
    std::size_t word_line_ = 1;  // of the last word
};

// That hold a word, from here on.
[[nodiscard]] std::size_t count_lines(TextScanner in);

// Without regard to case: some programs write everything in capitals.
[[nodiscard]] bool equal_words(std::string_view word, std::string_view lower_case);
[[nodiscard]] std::string lower_case(std::string_view word);
// In quotes, shortened, and with ? for what a terminal would not show.
[[nodiscard]] std::string quoted_word(std::string_view word);

}  // namespace palpate
