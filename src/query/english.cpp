#include "query/english.h"

#include <algorithm>
#include <unordered_map>

#include "query/words.h"

namespace hgg {
namespace {

using enum CueKind;

/// Cues of one meaning. In a pattern "(" and ")" hold words that may be left out, "|" parts words that may stand for
/// each other, "/" parts patterns.
struct Row {
  Cue cue;
  const char* patterns;
};

constexpr Cue relation(Relation r) { return {kRelation, static_cast<int>(r)}; }
constexpr Cue place(Placement p) { return {kPlace, static_cast<int>(p)}; }
constexpr Cue measure(Measure m, int sign, bool superlative) {
  return {kMeasure, static_cast<int>(m), sign, superlative};
}

// clang-format off: patterns are broken where they part, not inside a phrase.
const Row kRows[] = {
    {relation(Relation::kClosest),
     "closest to/nearest to/nearest/closest/closer to/nearer to/closer/nearer/most near/closest in proximity to/"
     "closes to/closet to/close by/proximate to"},
    {relation(Relation::kNear),
     "next to/near/near to/nearby/close to/close/beside/besides/by/alongside/adjacent to/at/around/against/"
     "up against/along/touching/against the side of/right by/nearly touching/next/with relation to/"
     "leaning against/leaning on/leaned against/pushed against/pushed up against/flush against/attached to/"
     "connected to/right next to/directly next to/flanking/surrounding/bordering/to the side of/on the side of/"
     "at the side of/at the end of/at the foot of/at the head of/on either side of/pushed under|into/"
     "tucked under|into/parallel to/joined to"},
    {relation(Relation::kFar),
     "farthest from/furthest from/farthest away from/furthest away from/far from/far away from/away from/"
     "farthest to/furthest to/farther from/further from/farther away from/further away from/most far from/"
     "most distant from/distant from/farthest/furthest/farther/further/not near/not close to/"
     "opposite end from/fartherest from/furtherest from"},
    {relation(Relation::kBetween),
     "between/in between/in the middle of|between/in the center|centre of/among/amongst/sandwiched between/"
     "in the midst of/midway between/surrounded by"},
    {relation(Relation::kOn),
     "on/on top of/atop/on the top of/upon/resting on/sitting on/lying on/laying on/placed on/hanging on/"
     "hanging from/mounted on/standing on/hanging off|off of/supported by/on the surface of/sitting on top of/"
     "resting on top of/on the back of"},
    {relation(Relation::kSupporting),
     "supporting/holding/carrying/topped with|by/that has on it/with on top/has on top/has on it"},
    {relation(Relation::kAbove),
     "above/over/over top of/higher than/directly above|over/hanging over|above/on the wall above|over"},
    {relation(Relation::kBelow),
     "under/below/underneath/beneath/lower than/directly under|below|underneath|beneath/on the bottom of/"
     "at the bottom of/at the base of/hidden under"},
    {relation(Relation::kFront),
     "in front of/in the front of/before/on the front of/at the front of/directly in front of/right in front of/"
     "ahead of"},
    {relation(Relation::kBehind),
     "behind/in back of/at the back of/directly behind/right behind/to the back of/in the back of"},
    {relation(Relation::kLeft),
     "(to|on|at) the (far|immediate|direct) left of/left of/(to|on|at) the left (hand) side of/left from/left to/"
     "(to) its left of/directly left of/immediately left of/(on|to) the left (side) from/just left of"},
    {relation(Relation::kRight),
     "(to|on|at) the (far|immediate|direct) right of/right of/(to|on|at) the right (hand) side of/right from/"
     "right to/directly right of/immediately right of/(on|to) the right (side) from/just right of"},
    {relation(Relation::kInside), "in/inside/inside of/within/into"},
    {relation(Relation::kFacing),
     "that faces/which faces/facing toward|towards/pointed at|towards|toward/turned to|towards|toward/looking out"},
    {relation(Relation::kAcross),
     "across from/opposite/opposite of|to|from/across the room from/directly across from/on the opposite side of/"
     "on the other side of/across/diagonal from|to"},
    {relation(Relation::kWith), "with/has/have/having/that has/contains/containing/which has/had/w"},
    {{kRelation, static_cast<int>(Relation::kWith), -1}, "without"},
    {place(Placement::kLeft),
     "leftmost/left most/(the) far|furthest|farthest|most left/"
     "(furthest|farthest|most|all the way|closest|far) (on|to|at|towards|toward) the|your|its|my (very|far) left/"
     "(on|to|at) the|your|its|my (far|very) left (hand) side/left hand side/left side/left hand|handed/left/"
     "lefthand|lefthanded/(on) the left|leftmost/furthest|farthest left/(more) to the left/left most side/"
     "most to the left/in|from the left"},
    {place(Placement::kRight),
     "rightmost/right most/(the) far|furthest|farthest|most right/"
     "(furthest|farthest|most|all the way|closest|far) (on|to|at|towards|toward) the|your|its|my (very|far) right/"
     "(on|to|at) the|your|its|my (far|very) right (hand) side/right hand side/right side/right hand|handed/right/"
     "righthand|righthanded/(on) the right|rightmost/furthest|farthest right/(more) to the right/right most side/"
     "most to the right/in|from the right"},
    {place(Placement::kMiddle),
     "middle/in the (very) middle/center/centre/central/in the (very) center|centre/middlemost/centermost/"
     "center most/middle most/centered"},
    {place(Placement::kFront),
     "front/in (the) front/(at|to|towards|toward) the front/frontmost/up front/foremost/forward/front most"},
    {place(Placement::kBack),
     "back/in (the) back/(at|to|towards|toward) the back|rear/in the rear/rear/"
     "further|farther|furthest|farthest back/backmost/rearmost/back most"},
    {place(Placement::kTop),
     "top/upper/(on|at|in) the top/topmost/uppermost/highest/higher/on top/above the others/higher up/up high/"
     "top most/upper most/higher than the others|other/most high"},
    {place(Placement::kBottom),
     "bottom/lower/(on|at|in) the bottom/lowest/bottommost/lowermost/bottom most/lower most/"
     "close|closest|closer to the ground|floor/underneath/near the ground|floor/base/down low"},
    {place(Placement::kCorner), "in the|a corner/corner/in the|a corner of (the|a) room/at the corner"},
    {place(Placement::kCentre),
     "(in) the middle|center|centre of the room/middle|center|centre of room/in the middle of everything"},
    {place(Placement::kWall),
     "on|along|against|by the wall/wall mounted/mounted on the wall/against a|the wall/on a wall/"
     "hung on the wall"},
    {place(Placement::kFloor),
     "on|at the floor|ground/on floor/lying|sitting|laying|standing on the floor|ground/floor level/"
     "touching the floor|ground"},
    {place(Placement::kAlone),
     "by itself/alone/on its own/all by itself/isolated/separate from the others/standing alone"},
    {measure(Measure::kSize, 1, true), "largest/biggest/most large/hugest"},
    {measure(Measure::kSize, 1, true), "larger/bigger/most massive/fatter/fattest"},
    {measure(Measure::kSize, 1, false),
     "large/big/huge/giant/massive/sizable/oversized/great/enormous/king size|sized/bulky/full size|sized"},
    {measure(Measure::kSize, -1, true), "smallest/littlest/tiniest/smaller/least large"},
    {measure(Measure::kSize, -1, false), "small/little/tiny/mini/compact/miniature/smallish"},
    {measure(Measure::kHeight, 1, true), "tallest/taller"},
    {measure(Measure::kHeight, 1, false), "tall/high"},
    {measure(Measure::kHeight, -1, true), "shortest/shorter"},
    {measure(Measure::kHeight, -1, false), "short/low/flat/squat"},
    {measure(Measure::kLength, 1, true), "longest/longer"},
    {measure(Measure::kLength, 1, false), "long/elongated"},
    {measure(Measure::kWidth, 1, true), "widest/wider/broadest/thickest/thicker"},
    {measure(Measure::kWidth, 1, false), "wide/broad/thick/double/fat"},
    {measure(Measure::kWidth, -1, true), "narrowest/narrower/thinnest/thinner/skinniest/skinnier"},
    {measure(Measure::kWidth, -1, false), "narrow/thin/skinny/slim/slender"},
    {{kColour},
     "white/black/gray/grey/brown/red/green/blue/yellow/orange/purple/pink/beige/tan/silver/gold/dark/darker/"
     "darkest/light colored/lighter/lightest/bright/wooden/cream/maroon/navy/teal/turquoise/"
     "light brown|blue|green|gray|grey/dark brown|blue|green|gray|grey|red/bluish/greenish/reddish/whitish/"
     "off white/wood/metal/metallic/colorful/violet/golden/light|dark colored/colored|coloured/wood colored"},
    {{kShape},
     "round/circular/square/rectangular/oval/cylindrical/triangular/curved/straight/open/closed/empty/full/"
     "cluttered/made/unmade/plastic/leather/glass/fabric/cushioned/padded/cloth/old/new/striped/patterned/plain/"
     "clear/dirty/clean/main/regular/normal/different/same/similar/upright/vertical/horizontal/folded/rolling/"
     "swivel/shaped/solid/single/l shaped/angled/tilted/transparent/hanging/standing/wheeled/visible/actual/"
     "entire/whole/half/parallel"},
    {{kOrdinal, 1}, "first"},
    {{kOrdinal, 2}, "second"},
    {{kOrdinal, 3}, "third"},
    {{kOrdinal, 4}, "fourth"},
    {{kOrdinal, 5}, "fifth"},
    {{kOrdinal, 6}, "sixth"},
    {{kOrdinal, 7}, "seventh"},
    {{kOrdinal, 8}, "eighth"},
    {{kOrdinal, 9}, "ninth"},
    {{kOrdinal, 10}, "tenth"},
    {{kOrdinal, 11}, "eleventh"},
    {{kOrdinal, 12}, "twelfth"},
    {{kOrdinal, -1}, "last/final"},
    {{kOrdinal, -2}, "second to last/second last/next to last"},
    {{kNumber, 2}, "two/2/pair of/both/couple of/pair"},
    {{kNumber, 3}, "three/3/trio of"},
    {{kNumber, 4}, "four/4"},
    {{kNumber, 5}, "five/5"},
    {{kNumber, 6}, "six/6"},
    {{kNumber, 7}, "seven/7"},
    {{kNumber, 8}, "eight/8"},
    {{kNumber, 10},
     "nine/ten/several/many/multiple/9/10/group of/set of/row of/bunch of/all/all of/stack of/pile of/some/few"},
    {{kFacing},
     "facing/face/when|if|as|while you|i|we are facing|looking at/when|if|as|while you|i|we face/"
     "when|if|while facing/when|if|while looking at|towards|toward/looking at|towards|toward/look at/"
     "when|if you look at|towards/viewing/when viewing/facing towards|toward/when|if you are facing|viewing/"
     "if|when you view/when|if standing facing/with your face to/view/looking straight at/"
     "when|if you look straight at/as you face/as you look at/standing in front of/when|if standing in front of/"
     "when|if you stand in front of/if|when you are standing in front of/facing the front of/"
     "looking at the front of/standing in front and facing/looking to/when looking to/facing directly/"
     "look towards|toward"},
    {{kFrom},
     "from/viewed from/seen from/looking from/when|if|while looking from/if|when you look from/standing at|by|on/"
     "when|if standing at|by|on/when|if you stand at|by|on/if|when you are standing at|by|on/"
     "if|when you are sitting at|on|in/when|if sitting at|on|in/if|when you sit at|on|in/"
     "when|if lying|laying on|in/if|when you are lying|laying on|in/if|when you lie|lay on|in/"
     "when viewed|viewing|looking from/with your back to|against/with my back to/as viewed|seen from/lying in"},
    {{kEntering},
     "entering/when|if|as|upon|while (you) enter|entering/when|if|as|while you walk in|into|through/"
     "walking in|into|through/when|if|as|while walking in|into|through/when|if|as you come in|into|through/"
     "coming in|into|through/enter|entered/when|if|as you go in|into/upon entry/upon entering/"
     "walk in|into|through/as one enters/just inside/when|as you first enter/when|as you first walk in|into"},
    {{kPronoun}, "it/they/them/itself/its/he/she/his/her/these/those"},
    {{kAny}, "one/ones/object/item/thing/option/choice/items/objects/target/1/answer/things/that one/this one"},
    {{kRobot}, "me/you/i/us/robot/myself/yourself/camera/viewer"},
    {{kRoom}, "room/rooms/space/scene/area/house/apartment/hallway/bedroom/bathroom/kitchen/office/classroom/building"},
    {{kDeterminer}, "the/a/an/my/your/our/their/each/every/any/another"},
    {{kThis}, "this"},
    {{kOther}, "other/others/rest of"},
    {{kPart},
     "side of/end of/edge of/foot of/head of/part of/section of/portion of/front of/back of/top of/bottom of/"
     "corner of/row of|with/line of/side/end/edge/section/portion/part/row/line/foot/head/one side of/"
     "left|right side of/far side|end of/half of/surface of/base of/leg|legs of/arm|arms of/column of/"
     "facing side of/other side|end of/set/group/stack/pile"},
    {{kThat},
     "that/which/who/where/whose/that is/which is/that are/who is/located/positioned/situated/placed/found/"
     "and it is/and is"},
    {{kAnd}, "and/but/or/also/then/plus"},
    {{kPick},
     "choose/pick/select/find/click/want/need/get/take/go to/bring/goto/grab/locate/identify/show/drive to/"
     "walk to/looking for/want is/looking for is/need is/click on/go/need to find/fetch/move to/navigate to/"
     "head to/correct"},
    {{kIs}, "is/are/was/be/am/being/were"},
    {{kOf}, "of/than"},
    {{kNot}, "not/no/isn/never/nor/doesn/dont/don/except/excluding/instead/neither/rather than/isnt/nothing"},
    {{kFiller},
     "to/for/from/please/there/just/very/most/more/only/right next/directly/immediately/slightly/so/as/if/when/"
     "while/can|could you/would/will/do/does/sitting/standing/lying/laying/resting/hanging/"
     "hangs|sits|stands|lies|lays|rests/your/much/bit/kind/sort/type/style/kind of|type of|sort of|lot of/here/up/"
     "down/out/off/what/how/some/both sides/together/way/all the way/itself/should/seen/see/sees/pushed/pulled/"
     "tucked/turned/extra/too/really/quite/almost/nearly/completely/fully/partially/even/each other/"
     "them|they|we|he|she/s/t/re/d/also/same/must/may/like/looks like|looks/appears|appear/using/used/into the/"
     "onto/through/about/after/because/since/until/during/per/via/either/else/such/own/now/exactly/barely/"
     "itself|themselves/least/less/rather/been/has been/instead of/options/choices/shown/displayed/than/let/make/"
     "give/put/want/go to|over to/side by side/possible/color/colour/colored/sized/"
     "size|height|length|width|shape|position|location|direction|perspective|view|angle/left|right or/"
     "located|situated|mounted|attached|placed|set/item|object or/hello|hi|hey/thanks|thank"},
};
// clang-format on

struct Patterns {
  std::unordered_map<std::string, Cue> cues;  // by the words with a space between two
  std::size_t longest = 0;                    // words
};

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  for (std::size_t at = text.find(separator); at != std::string::npos; from = at + 1, at = text.find(separator, from)) {
    parts.push_back(text.substr(from, at - from));
  }
  parts.push_back(text.substr(from));
  return parts;
}

/// All word sequences that a pattern stands for.
std::vector<std::string> expand(const std::string& pattern) {
  std::vector<std::string> all{""};
  for (std::string slot : split(pattern, ' ')) {
    const bool optional = slot.starts_with('(');
    std::erase_if(slot, [](char c) { return c == '(' || c == ')'; });
    std::vector<std::string> next;
    for (const std::string& before : all) {
      for (const std::string& word : split(slot, '|')) {
        next.push_back(before);
        next.back().append(before.empty() || word.empty() ? "" : " ").append(word);
      }
      if (optional) {
        next.push_back(before);
      }
    }
    all = std::move(next);
  }
  return all;
}

const Patterns& patterns() {
  static const Patterns kPatterns = [] {
    Patterns p;
    for (const Row& row : kRows) {
      for (const std::string& pattern : split(row.patterns, '/')) {
        for (const std::string& words : expand(pattern)) {
          p.cues.try_emplace(words, row.cue);  // what stands first in the table goes first
          p.longest = std::max<std::size_t>(p.longest, static_cast<std::size_t>(std::ranges::count(words, ' ')) + 1);
        }
      }
    }
    return p;
  }();
  return kPatterns;
}

/// The value of "1st", "22nd", "10th"; 0 where the word is no such thing.
int ordinalInDigits(const std::string& word) {
  constexpr std::size_t kMostDigits = 3;
  const std::size_t digits = std::min(word.find_first_not_of("0123456789"), word.size());
  const std::string ending = word.substr(digits);
  if (digits == 0 || digits > kMostDigits || (ending != "st" && ending != "nd" && ending != "rd" && ending != "th")) {
    return 0;
  }
  return std::stoi(word.substr(0, digits));
}

}  // namespace

FoundCue cueAt(std::span<const std::string> words, std::size_t at, std::size_t most) {
  FoundCue found;
  std::string key;
  const std::size_t end = std::min({words.size(), at + most, at + patterns().longest});
  for (std::size_t k = at; k < end; ++k) {
    key += (k == at ? "" : " ") + words[k];
    if (const auto it = patterns().cues.find(key); it != patterns().cues.end()) {
      found = {k - at + 1, it->second};
    }
  }
  if (const int value = found.length == 0 && at < end ? ordinalInDigits(words[at]) : 0; value > 0) {
    found = {1, {kOrdinal, value}};
  }
  return found;
}

bool isPlainWord(const std::string& word) {
  return !word.empty() && word != "," && word != "." && !patterns().cues.contains(word) && ordinalInDigits(word) == 0;
}

bool isRelationNoun(const std::string& word) {
  static const std::vector<std::string> kNouns{"side", "end",    "corner", "middle", "center", "row",  "left", "right",
                                               "top",  "bottom", "edge",   "back",   "front",  "line", "half", "stack"};
  return std::ranges::find(kNouns, word) != kNouns.end();
}

}  // namespace hgg
