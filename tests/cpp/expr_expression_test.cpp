// SPDX-License-Identifier: GPL-3.0-or-later
// The grammar of design §3 as a table of words, and every error with its column.
#include <gtest/gtest.h>

#include <random>

#include "expr/accepts.h"
#include "expr/expression.h"
#include "expr/side.h"

namespace sluice {
namespace {

std::vector<std::string> word(const std::string& text) {  // "L S'Egg' D" -> {"L", "S'Egg'", "D"}
  std::vector<std::string> events;
  std::string event;
  bool quoted = false;
  for (const char c : text + " ") {
    if (c == '\'') quoted = !quoted;
    if (c == ' ' && !quoted) {
      if (!event.empty()) events.push_back(event);
      event.clear();
    } else {
      event += c;
    }
  }
  return events;
}

struct Row {
  const char* expression;
  std::vector<const char*> yes, no;
};

TEST(Expression, TableOfWords) {
  const Row rows[] = {
      {"L", {"L", "L'Lamp'"}, {"", "L L", "D", "E", "L D"}},
      {"LD", {"L D", "L G"}, {"L S", "L F", "L", "D L"}},  // glossy is D|S
      {"LS", {"L S", "L G"}, {"L D", "L F"}},
      {"LG", {"L G"}, {"L D", "L S", "L F"}},
      {"LX", {"L D", "L S", "L G"}, {"L F", "L L", "L E"}},
      {"LF", {"L F", "L F'Gate'"}, {"L D", "L G"}},
      {"L.", {"L D", "L S", "L G", "L F"}, {"L L", "L E", "L", "L D D"}},
      {"L.*S", {"L S", "L G", "L D D S", "L F S'Egg'"}, {"L", "L D", "L S D", "S"}},
      {"L!D", {"L S", "L F"}, {"L D", "L G", "L L", "L E"}},  // D matches G, so !D does not
      {"L!G", {"L S", "L D", "L F"}, {"L G"}},
      {"L!L", {"L D", "L F"}, {"L L", "L E"}},  // still an interaction
      {"L!X", {"L F"}, {"L D", "L S", "L G"}},
      {"L!(D|S)", {"L F"}, {"L D", "L S", "L G"}},
      {"L!F*D", {"L D", "L S S D"}, {"L F D", "L"}},  // ! binds before *
      {"L[DF]", {"L D", "L G", "L F"}, {"L S"}},
      {"L[^DF]", {"L S"}, {"L D", "L G", "L F", "L L", "L E"}},
      {"[LE]D", {"L D", "E D"}, {"D D"}},
      {"L(S|D)+E", {"L S E", "L D S E"}, {"L E", "L F E"}},
      {"LS|LD", {"L S", "L D"}, {"L S L D", "L S D"}},  // concatenation binds tighter than |
      // postfix binds tighter than concatenation
      {"LSD*", {"L S", "L S D D"}, {"L S S D", "L S D S D"}},
      {"L(SD)*", {"L", "L S D S D"}, {"L S", "L S D S"}},
      {"LD?S", {"L S", "L D S"}, {"L D D S"}},
      {"LD{2}", {"L D D"}, {"L D", "L D D D"}},
      {"LD{2,}", {"L D D", "L D D D D"}, {"L D"}},
      {"LD{0,2}", {"L", "L D", "L D D"}, {"L D D D"}},
      {"LD{0}S", {"L S"}, {"L D S"}},
      {"LD{0,0}S", {"L S"}, {"L D S"}},
      {"LD{0,}", {"L", "L D D D"}, {"L S"}},
      {"L(D?S?){2}", {"L", "L S D S", "L D D", "L S S"}, {"L S S S", "L D D D"}},
      {"L(D*)*S", {"L S", "L D D S"}, {"L"}},
      // whitespace is free, but not in names
      {" L . {\t1 , 2 }\n S ' Egg' ", {"L D S' Egg'"}, {"L D S'Egg'"}},
      {"LS'Egg'", {"L S'Egg'", "L G'Egg'", "L S'Tray,Egg'"}, {"L S", "L S'egg'", "L D'Egg'", "L S'Eg'"}},
      {"LX'Egg'", {"L S'Egg'", "L D'Egg'", "L G'Egg'"}, {"L F'Egg'", "L S"}},
      {"LD'Floor,Wall'", {"L D'Floor'", "L D'Wall'", "L D'Wall,Floor'"}, {"L D'Floor wall'", "L D"}},
      {"L!S'Egg'", {"L S", "L D'Egg'", "L S'Cup'", "L F"}, {"L S'Egg'", "L G'Egg'"}},
      {"L[^S'Egg'F]*D", {"L S'Cup' D"}, {"L F D", "L S'Egg' D"}},
      {"L(!F'Move')*", {"L", "L F'Other'", "L F"}, {"L F'Move'"}},
      {"L'Lamp'S", {"L'Lamp' S"}, {"L S", "L'Sun' S"}},
      {"S C", {"S E", "S C"}, {"S", "E"}},
      {"LD'Стена'", {"L D'Стена'"}, {"L D'Стен'"}},
      {"L(S|D{0})D", {"L D", "L S D"}, {"L"}},
  };
  for (const Row& row : rows) {
    for (const char* yes : row.yes)
      EXPECT_TRUE(accepts(row.expression, word(yes))) << row.expression << " should accept " << yes;
    for (const char* no : row.no)
      EXPECT_FALSE(accepts(row.expression, word(no))) << row.expression << " should refuse " << no;
  }
}

TEST(Expression, NamesWithEscapes) {
  const std::vector<std::string> event{"L", R"(D'it\'s\, a \\')"};
  EXPECT_TRUE(accepts(R"(LD'it\'s\, a \\')", event));
  EXPECT_FALSE(accepts(R"(LD'its\, a \\')", event));
  EXPECT_EQ(parse_event(event[1]).names, std::vector<std::string>{R"(it's, a \)"});
}

TEST(Expression, ErrorsHaveTheirColumn) {
  struct {
    const char* text;
    int column;
    const char* says;
  } const rows[] = {
      {"", 1, "empty"},
      {"  ", 1, "empty"},
      {"L(", 2, "never closed"},
      {"L(S", 2, "never closed"},
      {"LS)", 3, "closes nothing"},
      {"L()", 2, "empty"},
      {"L|", 3, "missing"},
      {"|L", 1, "missing"},
      {"L||S", 3, "missing"},
      {"*L", 1, "nothing stands before"},
      {"LS**", 4, "only one"},
      {"LS*?", 4, "only one"},
      {"LS{2}{3}", 6, "only one"},
      {"LS{", 4, "count"},
      {"LS{,2}", 4, "count"},
      {"LS{2", 5, "write }"},
      {"LS{3,2}", 6, "smaller"},
      {"LS{2,x}", 6, "count"},
      {"LS{-1}", 4, "count"},
      {"LS{257}", 4, "256"},
      {"L!", 3, "after !"},
      {"L!.", 3, "after !"},
      {"L!!D", 3, "after !"},
      {"L!(DS)", 5, "| between"},
      {"L!((D)|S)", 4, "inside !("},
      {"L!(D|S", 7, "| between"},
      {"L[", 2, "never closed"},
      {"L[]", 3, "empty"},
      {"L[^]", 4, "empty"},
      {"L[D|S]", 4, "side by side"},
      {"L[(D)]", 3, "side by side"},
      {"L]", 2, "closes nothing"},
      {"L}", 2, "closes nothing"},
      {"LQ", 2, "no event"},
      {"Ld", 2, "write D"},
      {"L D'", 4, "never closed"},
      {"LD''", 4, "name is missing"},
      {"LD'a,'", 6, "name is missing"},
      {"LD',a'", 4, "name is missing"},
      {"LD'a\\b'", 5, "backslash"},
      {"LD'a\\", 5, "backslash"},
      {"L'Floor", 2, "never closed"},
      {"'Floor'", 1, "its kind"},
      {"LD\"a\"", 3, "straight"},
      {"LDé", 3, "no event"},
      {"L'é'Q", 5, "no event"},
      {"L\xff", 2, "UTF-8"},
      {"L\xc3", 2, "UTF-8"},
      {"L\xed\xa0\x80", 2, "UTF-8"},
      {"L$", 2, "no event"},
      {"L.'Egg'", 3, "its kind"},
  };
  for (const auto& row : rows) {
    try {
      (void)parse_expression(row.text, "Edit");
      ADD_FAILURE() << row.text << " was accepted";
    } catch (const ExpressionError& e) {
      EXPECT_EQ(e.column, row.column) << row.text << ": " << e.what();
      EXPECT_NE(std::string(e.what()).find(row.says), std::string::npos) << row.text << ": " << e.what();
      EXPECT_EQ(e.item, "Edit");
    }
  }
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(Expression, Limits) {
  const auto column_of = [](const std::string& text) {
    try {
      (void)parse_expression(text);
    } catch (const ExpressionError& e) { return e.column; }
    return 0;
  };
  EXPECT_EQ(column_of("L" + repeated(" ", 1022) + "S"), 0);
  EXPECT_EQ(column_of("L" + repeated(" ", 1023) + "S"), 1025);
  EXPECT_EQ(column_of("LD'" + repeated("é", 1020) + "'"), 0);  // characters, not bytes
  EXPECT_EQ(column_of(repeated("(", 64) + "L" + repeated(")", 64)), 0);
  EXPECT_EQ(column_of(repeated("(", 65) + "L" + repeated(")", 65)), 65);
  EXPECT_EQ(column_of(repeated("(", 1024)), 65);
  EXPECT_EQ(column_of("L" + repeated("D", 255)), 0);
  EXPECT_GT(column_of("L" + repeated("D", 256)), 0);
  EXPECT_EQ(column_of("L(D{15}){17}"), 0);  // 256 symbols
  EXPECT_EQ(column_of("L((D{16}){16}){16}"), 15);
  EXPECT_EQ(column_of("L((((D{99}){99}){99}){99})"), 12);
  EXPECT_EQ(column_of("L((((D{0}){256}){256}){256}){256}"), 0);  // no symbol at all
}

TEST(Expression, SideIsAPropertyOfTheLanguage) {
  for (const char* light : {"L", "L.*S D", "L(S|D)*", "LS|LD", "(L|L'Sun')S", "L'a'{1}D", "(LD{0}|L)S",
                            "L(!(X|F)E)?S", "L|E!(X|F)", "LF'E'"})
    EXPECT_EQ(check_edit_expression(light), Side::Light) << light;
  for (const char* view : {"E", "SE", "S+E", ".*E", "DE|SE", "(S'Mirror'|F)*E", "C", "!D E", "XE", "[DS]E"})
    EXPECT_EQ(check_edit_expression(view), Side::View) << view;

  struct {
    const char* text;
    int column;
    const char* says;
  } const rows[] = {
      {".*SD", 1, "write L first"},    {"D", 1, "write L first"},     {"L.*E", 4, "without the other"},
      {"L|E", 3, "without the other"}, {"L*S", 3, "begins with L"},   {"LS|D", 4, "begins with L"},
      {".*LS", 1, "begins with L"},    {"[LD]S", 1, "begins with L"}, {"L?", 1, "empty path"},
      {"SE|S", 4, "ends with E"},      {"S[ED]", 2, "ends with E"},   {"E?", 1, "empty path"},
      {"EE*S?", 4, "ends with E"},     {"DE", 1, "never acts"},       {"S(D|G)E", 3, "never acts"},
      {"DS*E", 1, "never acts"},       {"!(X|F)", 1, "no path"},      {"D{0}", 1, "no path"},
      {"GE", 1, "never acts"},
  };
  for (const auto& row : rows) {
    try {
      (void)check_edit_expression(row.text, "Edit");
      ADD_FAILURE() << row.text << " was accepted";
    } catch (const ExpressionError& e) {
      EXPECT_EQ(e.column, row.column) << row.text << ": " << e.what();
      EXPECT_NE(std::string(e.what()).find(row.says), std::string::npos) << row.text << ": " << e.what();
    }
  }
}

TEST(Expression, LayersAreWholePaths) {
  for (const char* layer : {"LE", "L.*E", "LS+DE", "LDE|LSE"})
    EXPECT_NO_THROW((void)parse_layer_expression(layer)) << layer;
  for (const auto& [text, column] :
       {std::pair{"L.*", 1}, {".*E", 1}, {"L.*E?", 1}, {"LE|D", 4}, {"(LE)?", 1}}) {
    try {
      (void)parse_layer_expression(text);
      ADD_FAILURE() << text << " was accepted";
    } catch (const ExpressionError& e) { EXPECT_EQ(e.column, column) << text << ": " << e.what(); }
  }
}

TEST(Expression, EventsOfWords) {
  EXPECT_EQ(parse_event("S'Egg,Glass things'").kind, Event::S);
  EXPECT_EQ(parse_event("S'Egg,Glass things'").names, (std::vector<std::string>{"Egg", "Glass things"}));
  EXPECT_EQ(parse_event(" C ").kind, Event::E);
  for (const char* wrong : {"", "X", "X'Egg'", ".", "LD", "!D", "[D]D", "D*", "D'"})
    EXPECT_THROW((void)parse_event(wrong), ExpressionError) << wrong;
}

// numerics §4: no crash, and every error has a column that lies in the text or right behind it.
TEST(Expression, RandomTextNeverCrashes) {
  const std::vector<std::string> pieces{
      "L", "E",   "D",  "S",      "G",    "F",   "X",    "C",     ".",  "!",     "(",
      ")", "[",   "]",  "^",      "|",    "*",   "+",    "?",     "{",  "}",     "{2}",
      ",", "{1,", "3",  " ",      "'",    "'a'", "\\",   "é",     "\n", "'b,c'", "L",
      "(", ")*",  "(D", "{0,20}", "!(S|", "[^",  "\xff", "99999", "..", "{256}", "\xf0\x9f\x8c\x9e"};
  std::mt19937 random(1);
  int parsed = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::string text;
    const auto length = random() % (i % 100 == 0 ? 600 : 16);
    for (unsigned k = 0; k < length; ++k)
      text += i % 7 == 0 ? std::string(1, static_cast<char>(random())) : pieces[random() % pieces.size()];
    try {
      const Expression expression = parse_expression(text);
      ++parsed;
      (void)side_of(expression);
    } catch (const ExpressionError& e) {
      ASSERT_GE(e.column, 1) << text;
      ASSERT_LE(e.column, static_cast<int>(text.size()) + 1) << text;
      ASSERT_GT(std::string(e.what()).size(), 10u) << text << "#" << e.what();
    }
  }
  EXPECT_GT(parsed, 1000);  // the texts are not all nonsense
}

}  // namespace
}  // namespace sluice
