// A journal from a disk that has seen better days: it is read, or refused with its line.
#include <string>

#include "devices/session/journal.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace palpate;
    const std::string text(reinterpret_cast<const char*>(data), size);
    try {
        const Journal journal = parse_journal(text, "journal.jsonl");
        require(journal.bytes + journal.dropped_bytes == size, "every byte is read or dropped");
        require(journal.lines > journal.moves.size(), "there is a header");
    } catch (const JournalDamaged& damaged) {
        require(std::string(damaged.what()).rfind("journal.jsonl:", 0) == 0, "the message says where");
    }
    // The check sum keeps changed lines from the reader behind it: give it lines whose sum fits.
    std::string signed_text;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string line = text.substr(begin, end - begin);
        line = line.substr(0, line.rfind(",\"crc\""));
        signed_text += line + ",\"crc\":\"" + digest(line) + "\"}\n";
        begin = end + 1;
    }
    try {
        (void)parse_journal(signed_text, "journal.jsonl");
    } catch (const JournalDamaged&) {
        return 0;
    }
    return 0;
}
