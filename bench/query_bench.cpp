// What a question costs: reading it and finding what it means, on a map of 2,000 things.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "map/import.h"
#include "query/answer.h"

namespace hgg::query_bench {
namespace {

/// Things of 40 classes on 200 x 200 m, as an import makes them.
QueryScene bigScene(int count) {
  static const std::vector<std::string> kNames{
      "chair",     "table",   "desk",   "couch",   "bed",        "lamp",    "door",       "window",
      "pillow",    "monitor", "shelf",  "cabinet", "trash can",  "box",     "picture",    "plant",
      "bookshelf", "sink",    "toilet", "mirror",  "towel",      "curtain", "whiteboard", "backpack",
      "keyboard",  "printer", "stool",  "bench",   "radiator",   "clock",   "bottle",     "cup",
      "book",      "fan",     "tv",     "dresser", "nightstand", "rug",     "bag",        "armchair"};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(-100, 100), edge(0.2, 2);
  std::string objects;
  for (int k = 0; k < count; ++k) {
    objects += fmt::format(R"({}{{"id":{},"label":"{}","center":[{},{},0.5],"size":[{},{},1]}})", k == 0 ? "" : ",", k,
                           kNames[static_cast<std::size_t>(k) % kNames.size()], at(random), at(random), edge(random),
                           edge(random));
  }
  return sceneOf(*importJson(fmt::format(R"({{"objects":[{}]}})", objects)));
}

const std::vector<std::string> kTexts{
    "go to the chair closest to the door",
    "the lamp on the table next to the bed",
    "facing the window, the second chair from the left",
    "The large brown table between the couch and the bookshelf. It has a plant on it.",
    "find the trash can that is farthest from the printer",
    "When you enter the room, it is the pillow on the right side of the bed that is near the nightstand.",
    "the bananna next to the refrigerator"};

void ReadAndGround(benchmark::State& state) {
  const QueryScene scene = bigScene(static_cast<int>(state.range(0)));
  const Lexicon lexicon(scene.class_names, {});
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(answerText(kTexts[k++ % kTexts.size()], scene, lexicon, std::nullopt, 5));
  }
}
BENCHMARK(ReadAndGround)->Arg(50)->Arg(2'000)->Unit(benchmark::kMillisecond);

/// A thousand questions to 2,000 things, as `hggmap query --batch` asks them. The counters are of single questions.
void AThousandQuestions(benchmark::State& state) {
  const QueryScene scene = bigScene(2'000);
  const Lexicon lexicon(scene.class_names, {});
  std::vector<double> ms;
  for (auto _ : state) {
    for (std::size_t k = 0; k < 1'000; ++k) {
      const auto begin = std::chrono::steady_clock::now();
      benchmark::DoNotOptimize(answerText(kTexts[k % kTexts.size()], scene, lexicon, std::nullopt, 5));
      ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    }
  }
  std::ranges::sort(ms);
  state.counters["p50_ms"] = ms[ms.size() / 2];
  state.counters["p99_ms"] = ms[ms.size() * 99 / 100];
}
BENCHMARK(AThousandQuestions)->Iterations(1)->Unit(benchmark::kSecond);

void OpenTheLexicon(benchmark::State& state) {
  const QueryScene scene = bigScene(100);
  for (auto _ : state) {
    benchmark::DoNotOptimize(Lexicon(scene.class_names, {}));
  }
}
BENCHMARK(OpenTheLexicon)->Unit(benchmark::kMillisecond);

void SceneOfAMap(benchmark::State& state) {
  std::string objects;
  for (int k = 0; k < 2'000; ++k) {
    objects +=
        fmt::format(R"({}{{"id":{},"label":"chair","center":[{},0,0],"size":[1,1,1]}})", k == 0 ? "" : ",", k, k);
  }
  const Map map = *importJson(fmt::format(R"({{"objects":[{}]}})", objects));
  for (auto _ : state) {
    benchmark::DoNotOptimize(sceneOf(map));
  }
}
BENCHMARK(SceneOfAMap)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::query_bench
