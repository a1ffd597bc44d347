#include "devices/grbl/grbl_message.h"

#include <gtest/gtest.h>

#include "tests/random.h"

namespace palpate::grbl::grbl_message_test {
namespace {

template <typename T>
T parsed(std::string_view line) {
    const Message message = parse(line);
    EXPECT_TRUE(std::holds_alternative<T>(message)) << line;
    return std::holds_alternative<T>(message) ? std::get<T>(message) : T{};
}

TEST(GrblMessage, AnswersAreRead) {
    parsed<Ok>("ok");
    EXPECT_EQ(parsed<Error>("error:33").code, 33);
    EXPECT_EQ(parsed<Alarm>("ALARM:4").code, 4);
    for (const char* damaged : {"o", "okk", " ok", "error:", "error:x", "error:-1", "error:3 3", "ALARM:", "LARM:4", "ALARM:4x", ""}) {
        parsed<Unknown>(damaged);
    }
}

TEST(GrblMessage, BannersOfBothFirmwaresAreRead) {
    EXPECT_EQ(parsed<Banner>("Grbl 1.1h ['$' for help]").version, "Grbl 1.1h");
    EXPECT_EQ(parsed<Banner>("GrblHAL 1.1f ['$' or '$HELP' for help]").version, "GrblHAL 1.1f");
    parsed<Unknown>("Grbl");
}

TEST(GrblMessage, AProbeReportIsReadInMillimetresAndInches) {
    const auto report = parsed<ProbeReport>("[PRB:1.000,-20.125,-3.500:1]");
    EXPECT_EQ(report.position, Point(1, -20.125, -3.5));
    EXPECT_TRUE(report.contact);
    EXPECT_FALSE(parsed<ProbeReport>("[PRB:0.000,0.000,0.000:0]").contact);
    EXPECT_EQ(parsed<ProbeReport>("[PRB:0.0394,0.0000,-1.0000:1]").position, Point(0.0394, 0, -1));
    // A fourth axis is there and does not matter.
    EXPECT_EQ(parsed<ProbeReport>("[PRB:1.000,2.000,3.000,4.000:1]").position, Point(1, 2, 3));
}

TEST(GrblMessage, StatusReportsOfBothFirmwaresAreRead) {
    const auto idle = parsed<Status>("<Idle|MPos:0.000,-1.250,0.000|FS:0,0|WCO:0.000,5.000,0.000>");
    EXPECT_EQ(idle.state, "Idle");
    EXPECT_EQ(*idle.machine, Point(0, -1.25, 0));
    EXPECT_EQ(*idle.offset, Point(0, 5, 0));
    EXPECT_FALSE(idle.probe_closed);
    const auto hold = parsed<Status>("<Hold:0|WPos:1.000,2.000,3.000|Bf:35,1023|FS:0,0|Pn:XP|H:1|A:|TLR:0>");
    EXPECT_EQ(hold.substate, 0);
    EXPECT_EQ(*hold.work, Point(1, 2, 3));
    EXPECT_FALSE(hold.machine);
    EXPECT_TRUE(hold.probe_closed);
    EXPECT_EQ(hold.homed, true);
    EXPECT_TRUE(parsed<Status>("<Alarm|MPos:0.000,0.000,0.000|Pn:O|H:0>").probe_unplugged);
    const auto running = parsed<Status>("<Run|MPos:0.000,0.000,0.000|FS:300,0|Ov:120,50,100|A:SFM>");
    EXPECT_EQ(running.feed_override, 120);
    EXPECT_EQ(running.running, "SFM");
    EXPECT_EQ(hold.running, "");
    EXPECT_FALSE(hold.feed_override);
    EXPECT_EQ(parsed<Status>("<Run|MPos:0.000,0.000,0.000|Ov:10,100,100|A:T>").running, "") << "a tool change is none of it";
    for (const char* overrides : {"100,100", "100100,100", "100,100100", "1001,00,100", "100,,100", "0,100,100", "x,100,100", ""}) {
        parsed<Unknown>("<Idle|MPos:0.000,0.000,0.000|Ov:" + std::string(overrides) + ">");
    }
    for (const char* damaged : {"<Idle|MPos:0.000,0.000|FS:0,0>", "<Idle>", "<Ile|MPos:0.000,0.000,0.000>", "<Idle|MPos:0.00,0.000,0.000>",
                                "<Idle|MPos:0.000,0.000,0.000", "<Hold:x|MPos:0.000,0.000,0.000>", "<>", "<|>"}) {
        parsed<Unknown>(damaged);
    }
}

TEST(GrblMessage, SettingsAndMessagesAreRead) {
    EXPECT_EQ(parsed<Setting>("$110=500.000").number, 110);
    EXPECT_EQ(parsed<Setting>("$110=500.000").value, "500.000");
    EXPECT_EQ(parsed<Setting>("$0=10 (step pulse, usec)").value, "10");
    EXPECT_EQ(parsed<Feedback>("[MSG:'$H'|'$X' to unlock]").kind, "MSG");
    EXPECT_EQ(parsed<Feedback>("[VER:1.1h.20190825:]").text, "1.1h.20190825:");
    parsed<Unknown>("$H");
    parsed<Unknown>("$=1");
}

// A cable that loses bytes: whatever is lost, no other contact is read than the one that was reported, but for a lost digit
// before the point or a lost sign, which the driver finds out by where the machine is.
TEST(GrblMessage, ALostByteDoesNotMakeAnotherContact) {
    const std::string line = "[PRB:12.345,-67.890,-3.141:1]";
    const auto whole = parsed<ProbeReport>(line);
    for (std::size_t k = 0; k < line.size(); ++k) {
        std::string damaged = line;
        damaged.erase(k, 1);
        const Message message = parse(damaged);
        const auto* report = std::get_if<ProbeReport>(&message);
        if (report == nullptr) continue;
        EXPECT_TRUE(report->contact) << damaged;
        EXPECT_GE((report->position - whole.position).norm(), 2) << damaged;
    }
}

// Of four decimals one may get lost; who knows the units knows that.
TEST(GrblMessage, OtherDecimalsThanTheUnitsHaveAreDamage) {
    const auto is_read = [](std::string_view line, std::size_t decimals) {
        return !std::holds_alternative<Unknown>(parse(line, decimals));
    };
    for (const std::string line :
         {"[PRB:0.3937,0.0000,-1.0000:1]", "<Idle|WPos:0.3937,0.0000,-1.0000|FS:0.0,0|WCO:0.0000,0.0000,0.0000>"}) {
        EXPECT_TRUE(is_read(line, 4));
        EXPECT_FALSE(is_read(line, 3));
        for (const std::size_t digit : {line.find("37"), line.find("00,"), line.find("-1.00") + 3}) {
            std::string damaged = line;
            damaged.erase(digit, 1);
            EXPECT_FALSE(is_read(damaged, 4)) << damaged;
        }
    }
    EXPECT_TRUE(is_read("[PRB:0.393,0.000,-1.000:1]", 3));
    EXPECT_FALSE(is_read("[PRB:0.393,0.000,-1.000:1]", 4));
}

TEST(GrblMessage, LinesEndWithAnyEndOfLine) {
    LineBuffer buffer;
    buffer.append("ok\r\n[MSG:a]\nerr");
    EXPECT_EQ(buffer.next(), "ok");
    EXPECT_EQ(buffer.next(), "[MSG:a]");
    EXPECT_EQ(buffer.next(), std::nullopt);
    buffer.append("or:9\r");
    EXPECT_EQ(buffer.next(), "error:9");
    EXPECT_EQ(buffer.next(), std::nullopt);
}

TEST(GrblMessage, NoiseWithoutEndsOfLinesDoesNotFillTheMemory) {
    LineBuffer buffer;
    std::size_t seen = 0;
    for (int k = 0; k < 1000; ++k) {
        buffer.append(std::string(100, 'x'));
        while (const auto line = buffer.next()) {
            EXPECT_LE(line->size(), 512U);
            seen += line->size();
        }
    }
    EXPECT_GE(seen, 99'000U);
}

TEST(GrblMessage, EveryCodeIsExplained) {
    for (int code = -1; code < 100; ++code) {
        EXPECT_NE(explain_error(code), "");
        EXPECT_NE(explain_alarm(code), "");
    }
    EXPECT_TRUE(loses_position(1) && loses_position(3) && loses_position(9));
    EXPECT_FALSE(loses_position(2) || loses_position(4) || loses_position(5));
}

// Whatever comes in is a message, and never one with numbers that are not finite.
TEST(GrblMessage, AnyBytesAreRead) {
    constexpr std::uint64_t kSeed = 11;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const std::vector<std::string> good = {"ok",
                                           "error:9",
                                           "ALARM:1",
                                           "[PRB:1.000,2.000,3.000:1]",
                                           "<Hold:0|MPos:0.000,0.000,0.000|Pn:P>",
                                           "$110=500.000",
                                           "[MSG:x]",
                                           "Grbl 1.1h ['$' for help]"};
    const std::string alphabet = "0123456789.,:|<>[]$-+eEPnMoskWCOxA \t\xff";
    for (int k = 0; k < 200'000; ++k) {
        std::string line = random.one_of(good);
        for (std::size_t changes = 1 + random.below(4); changes > 0; --changes) {
            const std::size_t at = random.below(line.size() + 1);
            if (random.chance(0.5)) line.erase(at, 1 + random.below(3));
            if (random.chance(0.7)) line.insert(std::min(at, line.size()), 1, alphabet[random.below(alphabet.size())]);
        }
        const Message message = parse(line);
        if (const auto* report = std::get_if<ProbeReport>(&message)) {
            ASSERT_TRUE(report->position.allFinite()) << line;
        }
        if (const auto* status = std::get_if<Status>(&message)) {
            ASSERT_TRUE(status->machine || status->work) << line;
        }
    }
}

}  // namespace
}  // namespace palpate::grbl::grbl_message_test
