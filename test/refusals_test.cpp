// What the program refuses: exit status 2 and a sentence that says what, where and what to do. A table has a
// row a line: what is typed, or what of a good file is replaced by what, and a part of the sentence.

#include "harness/scene/scene.hpp"
#include "test/files.hpp"
#include "test/person.hpp"
#include "test/program.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

std::string without_blanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == text.npos ? "" : std::string(text.substr(first, text.find_last_not_of(' ') - first + 1));
}

/// `text` at the first and only `border`; "\n" in it is a new line.
std::pair<std::string, std::string> halves(std::string_view text, std::string_view border) {
  const std::size_t at = text.find(border);
  EXPECT_NE(at, text.npos) << text;
  std::pair<std::string, std::string> both{without_blanks(text.substr(0, at)),
                                           without_blanks(text.substr(at + border.size()))};
  for (std::string* half : {&both.first, &both.second}) {
    for (std::size_t line = 0; (line = half->find("\\n", line)) != std::string::npos; ++line) {
      half->replace(line, 2, 1, '\n');
    }
  }
  return both;
}

class Refusals : public testing::Test {
protected:
  /// Types something in the folder of the test.
  test::Outcome type(const std::string& words) const {
    return test::hdmbench(words, "cd " + folder_.path().string() + ";");
  }

  void expect_refused(const std::string& words, const std::string& says) const {
    const test::Outcome outcome = type(words);
    EXPECT_EQ(outcome.status, 2) << words << '\n' << outcome.output;
    EXPECT_THAT(outcome.output,
                AllOf(HasSubstr(says), Not(HasSubstr("internal error")), Not(ContainsRegex("[0-9]{20}"))))
        << words;
    for (const char* output : {"o.nrrd", "out/displacement.nrrd", "out/modulus.nrrd", "o.svg"}) {
      EXPECT_FALSE(fs::exists(folder_.path() / output)) << words;
    }
  }

  template <typename Visit>
  static void for_each_row(std::string_view table, Visit visit) {
    int rows = 0;
    for (std::size_t begin = 1; begin < table.size(); ++rows) {
      const std::size_t end = table.find('\n', begin);
      const std::string line(table.substr(begin, end - begin));
      SCOPED_TRACE(line);
      const auto [given, says] = halves(line, " | ");
      visit(given, says);
      begin = end + 1;
    }
    EXPECT_GT(rows, 3);
  }

  /// Rows "words | says"; `before` and `behind` the words of a row stand those of all.
  void expect_refused_words(std::string_view table, const std::string& before = "",
                            const std::string& behind = "") const {
    for_each_row(table, [&](const std::string& words, const std::string& says) {
      expect_refused(before + words + behind, says);
    });
  }

  /// Rows "old -> new | says" of the file `name`, which is good as it stands in `text`; a line "=" in it
  /// begins the file `second`. `words` read them.
  void expect_refused_edits(std::string_view table, const std::string& words, const std::string& name,
                            const std::string& text, const std::string& second = "") const {
    const auto write = [&](const std::string& whole) {
      const std::size_t border = whole.find("\n=\n");
      (void)folder_.write(name, whole.substr(0, border == whole.npos ? border : border + 1));
      if (!second.empty()) {
        (void)folder_.write(second, whole.substr(border + 3));
      }
    };
    write(text);
    const test::Outcome good = type(words);
    ASSERT_EQ(good.status, 0) << good.output;
    fs::remove(folder_.path() / "o.nrrd");
    for_each_row(table, [&](const std::string& edit, const std::string& says) {
      const auto [from, to] = halves(edit + " ", "-> ");
      std::string changed = text;
      const std::size_t at = changed.find(from);
      ASSERT_NE(at, changed.npos) << from;
      write(changed.replace(at, from.size(), to));
      expect_refused(words, says);
    });
  }

  test::TemporaryFolder folder_;
};

TEST_F(Refusals, OfWords) {
  expect_refused_words(R"(
fly | fly
verifi | did you mean verify?
run square --size 9 --iteration 3 | did you mean --iterations?
run square --size=9 --colour=3 | run has no option --colour; hdmbench run --help lists them
run | scene
run nowhere.toml | nowhere.toml
run . | cannot be read
verify square --size 0 | "0"
verify square --size 12y | 12y
verify square --size -5 | -5
verify square --size 2000000 | GiB of memory
verify square --backends none | there is no backend "none"
verify square --size 9 --require nothing | there is no backend "nothing"
verify square --size 9 --backends openmp --device Voodoo2 | Voodoo2
verify square --size 9 --steps '' | has 0 candidates; give 1 to 16
verify square --size 9 --steps 0,x | "x" is not a number
verify square --size 9 --steps 0,,1 | not a number
verify square --size 9 --steps 0,nan | finite
verify square --size 9 --steps inf | finite
verify square --size 9 --steps 0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16 | has 17 candidates; give 1 to 16
verify square --size 9 --penalty 0 | penalty K
verify square --size 9 --penalty nan | penalty
verify square --size 9 --prior-weight 0 | prior weight alpha is 0
verify square --size 9 --prior-weight 1 | prior weight alpha is 1
verify square --size 9 --prior-weight nan | prior weight alpha is nan
run square --size 9 --penalty 1e30 --prior-weight 1e-30 | as a 32-bit float
verify square --size 9 --iterations -1 | give 0 ... 100000000
verify square --size 9 --threads -1 | not in range 0 to 4096
verify square --size 9 --epsilon -1 | not in range 0
bench square --size 9 --repeat -1 | not in range 1 to
bench square --size 9 --repeat 0 | repeat
bench square --size 9 --reference nobody | nobody
bench --with old.json | --compare
verify square --size 9 --reference none | there is no backend "none"
verify square --size 9 --reference openmp --backends openmp | no backend is left to compare with openmp
verify square --size 16 --start-level 99 | 16 x 16 pixels have the levels 0 (full resolution) ... 4
verify square --size 16 --start-level -1 | start level -1
verify square --sizes 16,,32 | --sizes 16,,32: a word is missing
verify square --size=,16 | --size ,16: a word is missing
verify square --size 9 --backends openmp, | --backends openmp,: a word is missing
verify square --size 9 --stop never | never
verify square --size 9 --json /no/such/folder/a.json | /no/such/folder
accuracy square --size 9 --methods icm | accuracy has no option --methods
accuracy square --size 1x7 | at least 2 x 2
accuracy square --size 20 --json /nowhere/a.json | /nowhere
accuracy square --size 20 --stop still | accuracy has no option --stop
tradeoff square --size 9 --methods icm,magic | magic
run square --size 9 --update sequential | --backend scalar
run square --size 9 --energy elastic --robust -2 | not in range 0.000001 to 1000000
run square --size 9 --stride 4 | --stride is for --energy elastic
run square --size 20 --energy elastic --stride 9 | leaves an image of 3 x 3 sites
run square --size 20 --energy elastic --stride 12 | every 12th pixel
run square --size 70 --energy elastic --stride 61 | every 61st pixel
run square --size 9 --output /proc/x | /proc/x: the folder cannot be made: No such file
run square --size 9 --accuracy 3cm | give pixels above 0, as 0.35px, or millimetres, as 0.1mm
run square --size 9 --accuracy 1px --energy hdm | --energy hdm asks for the thesis's: give --energy elastic
run square --size 9 --within 9ms --energy hdm | or --method and --iterations in place of --accuracy
run square --size 9 --accuracy 1px --penalty 9 | leave out --start-level
report /no/such/results | /no/such/results
probe --device nonsense | no backend has a device "nonsense"
probe --require openmp --device nonsense | openmp is needed but not there
rivals --orientation oblique | oblique
browser random --size 8 --method sequential --output /dev/null | cannot be compared in a browser
export | scene is required
export nowhere | no scene and no file
export square --size 0 | "0"
export square --size 9 --output /proc/none | /proc/none
energy-plot square --size 9 | --sites
energy-plot square --size 9 --sites 1,1 9,1 | there is no site 9,1
energy-plot square --size 9 --sites 1,1 1,1 | given twice
energy-plot square --size 9 --sites 1,1 2 | --sites
energy-plot square --size 9 --sites 1,1 1,2 --component z | component
energy-plot square --size 9 --sites 1,1 1,2 --points 1 | points
energy-plot square --size 9 --sites 1,1 1,2 --range 2,1 | range
energy-plot square --size 9 --sites 1,1 1,2 --output /none/o.svg | /none
tune square --size 9 --search luck | luck
tune square --size 9 --search annealing --range 0,1 | 0 < low < high < 1
tune square --size 9 --range 0.6,0.5 | low
tune square --size 9 --search annealing --evaluations 0 | evaluations
tune square --size 9 --search annealing --mask m.png | --truth FILE
tune square --size 9 --search annealing --truth none.nrrd | none.nrrd
tune square --size 9 --search annealing --backend none | there is no backend
)");
}

TEST_F(Refusals, OfOptionsWithoutEffect) {
  expect_refused_words(R"(
run square --size 9 --halo 4 | --halo has no effect here: ranks are several processes
run square --size 9 --sites-per-rank 4 --halo 4 | --sites-per-rank, --halo have no effect
run square --size 9 --explain | it explains a plan
run square --size 9 --accuracy 1px --iterations 3 | choose method, levels and iterations themselves
run square --size 9 --epsilon 1e-3 | --epsilon has no effect here
run square --size 9 --stop still --epsilon 1e-3 | --epsilon has no effect here
verify square --size 9 --epsilon 1e-3 | --epsilon has no effect here
tune square --size 9 --search-seed 3 | --search-seed has no effect here
tune square --size 9 --prior-weight 0.3 | tune has no option --prior-weight
tune square --size 9 --mask a.png | --truth FILE.nrrd
energy-plot square --size 9 --sites 1,1 2,2 --start --iterations 3 | nothing is solved
energy-plot square --size 9 --sites 1,1 2,2 --start --backend scalar | nothing is solved
atlas --list --json a.json | excludes
faults --list --json a.json | excludes
continuum --sizes 8 --quick | excludes
tradeoff square --size 9 --quick --repeat 3 | excludes
tradeoff square --size 9 --method icm | did you mean --methods?
rivals --spread | --spread requires --detection
rivals --detection 1 --planted growth | excludes
rivals --knobs 1 --other square | excludes
implementations --device 1 | implementations has no option --device
devices --no-cache | --no-cache requires --measure
accuracy square --size 9 --quick --full | excludes
fem-to-image a.txt --elements b.txt --size 9 --output c.nrrd --reach 2 | --interpolation nearest does
)");
}

constexpr const char* scene = R"(size = [8, 6]
[[tissue]]
label = 1
modulus = 20.0
[[shape]]
kind = "everything"
label = 1
[[condition]]
where = "left"
dx = -5.0
)";

TEST_F(Refusals, OfScenes) {
  expect_refused_edits(R"(
dx = -5.0 -> dx = nan | scene.toml:10
dx = -5.0 -> dx = "five" | must be a number
dx = -5.0 -> dx = 1e30 | dx has a displacement of 1e+30 pixels
dx = -5.0 -> dx = -5.0\nconfidence = 1.5 | within 0 ... 1
dx = -5.0 -> dxx = -5.0 | dxx is not a key
dx = -5.0 -> | give dx, dy or outward
dx = -5.0 -> dx = -5.0\ndeviation = 2.0 | deviation has no effect
dx = -5.0 -> dx = -5.0\nclosing = 0.1 | it belongs to where = "outside"
"left" -> "middle" | it must be one of left, right
"left"\ndx -> "outside"\noutward | no pixel has label 0
modulus = 20.0 -> modulus = 0.0 | scene.toml:4: [[tissue]] modulus is 0, it must be positive
modulus = 20.0 -> modulus = -3.0 | must be positive
modulus = 20.0 -> modulus = inf | must be finite
modulus = 20.0 -> modulus = 1e-60 | modulus
modulus = 20.0 -> modulus = 1e-39 | a 32-bit float must hold it and its inverse
modulus = 20.0 -> modulus = 1e39 | a 32-bit float must hold it and its inverse
modulus = 20.0 -> | modulus is missing
label = 1\nmodulus -> label = 2\nmodulus | label 1
size = [8, 6] -> size = [8, 0] | whole numbers >= 1
size = [8, 6] -> size = [8] | two numbers
size = [8, 6] -> | size is missing
size = [8, 6] -> size = [8, 6 | scene.toml:
size = [8, 6] -> size = [8, 6]\npenalty = 0.0 | penalty K
size = [8, 6] -> size = [8, 6]\nprior_weight = 1.5 | scene.toml:2: prior_weight
size = [8, 6] -> size = [8, 6]\npoisson = 0.6 | (-1, 0.5]
size = [8, 6] -> size = [8, 6]\nsteps = [] | has 0 candidates; give 1 to 16
size = [8, 6] -> size = [8, 6]\nsteps = "fast" | not a number
size = [8, 6] -> size = [8, 6]\nenergy = "plastic" | one of hdm, elastic
size = [8, 6] -> size = [8, 6]\nsteps = "fine"\nschedule.method = "closed-form" | closed-form does not take steps
size = [8, 6] -> size = [8, 6]\nrobust = 0.5 | it belongs to energy = "elastic"
size = [8, 6] -> size = [8, 6]\npenalti = 1.0 | scene.toml:2: penalti is not a key
size = [8, 6] -> size = [8, 6]\npenalti = 1.0 | did you mean penalty?
size = [8, 6] -> size = [8, 6]\nconditions = 1.0 | did you mean condition?
size = [8, 6] -> size = [8, 6]\ncolour = 1.0 | those understood are title, size, penalty, prior_weight
"everything" -> "rectangle" | centre is missing
"everything" -> "ellipse"\ncentre = [0.5, 0.5]\nsize = [0.1, 0.1] | unpainted
[[shape]] -> [schedule]\niterations = -1\n[[shape]] | iterations
[[shape]] -> [schedule]\niteration = 1\n[[shape]] | did you mean iterations?
[[shape]] -> [schedule]\nstop = "never"\n[[shape]] | fixed, still, energy
[[shape]] -> [schedule]\nepsilon = 1e-3\n[[shape]] | it belongs to stop = "energy"
[[shape]] -> [schedule]\nstop = "still"\nepsilon = 1e-3\n[[shape]] | epsilon has no effect
[[shape]] -> [schedule]\nstart_level = 4\n[[shape]] | 8 x 6 pixels have the levels 0 (full resolution) ... 3
[[shape]] -> [schedule]\nstart_level = -1\n[[shape]] | start level -1
[[shape]] -> [image]\nlabels = "a.png"\n[[shape]] | exactly one of these
)",
                       "run scene.toml", "scene.toml", scene);
  (void)folder_.write("empty.toml", "");
  expect_refused("run empty.toml", "a scene needs exactly one of these");
  (void)folder_.write("missing.toml", "[image]\nlabels = \"missing.png\"\n");
  expect_refused("run missing.toml", have_images() ? "missing.png" : "without image support");
}

TEST_F(Refusals, OfElasticScenes) {
  expect_refused_edits(R"(
"elastic" -> "elastic"\npenalty = 5 | :2: penalty has no effect
"elastic" -> "elastic"\nprior_weight = 0.5 | it belongs to energy = "hdm"
"elastic" -> "elastic"\nsteps = "fine" | steps has no effect
"elastic" -> "elastic"\nrobust = 0.0 | must be above 0 (pixels)
[[shape]] -> [schedule]\nmethod = "icm"\n[[shape]] | for the elastic energy
[[shape]] -> [schedule]\nstart_level = 0\n[[shape]] | start_level has no effect
[[shape]] -> [schedule]\nstop = "still"\n[[shape]] | stop has no effect
[[shape]] -> [schedule]\nalignment = "center"\n[[shape]] | alignment has no effect
dx = -5.0 -> dx = -5.0\nconfidence = 0.5\ndeviation = 1.0 | cannot stand beside confidence
dx = -5.0 -> dx = -5.0\ndeviation = -1.0 | at least 0 (pixels)
)",
                       "run scene.toml", "scene.toml",
                       std::string("energy = \"elastic\"\n") + scene + "dy = 0.0\n");
}

TEST_F(Refusals, OfLists) {
  if (!have_images()) {
    GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
  }
  expect_refused_edits(R"(
1,0,0,5,6\n2,1,0,5,6\n3,1,1,5,6\n4,0,1,5,6 -> # nothing | nodes.csv: has no node
2,1,0,5,6 -> 2,1,0,5 | nodes.csv:2: a node is five numbers
2,1,0,5,6 -> 1,1,0,5,6 | nodes.csv:2: the node 1 is in line 1 already
1,0,0,5,6 -> 1,0,0,nan,6 | nodes.csv:1: the displacement u is nan, it must be finite
1,0,0,5,6 -> 1,0,inf,5,6 | finite
1,0,0,5,6 -> 1,0,zero,5,6 | nodes.csv:1: the node's y is "zero"
1,0,0,5,6 -> 1.5,0,0,5,6 | which is not a whole number
1,0,0,5,6 -> x,0,0,0,0 | the node's id is "x"
1,0,0,5,6 -> 1;0,5;0;5;6 | "0,5", which is not a number
1,0,0,5,6 -> id,x,y,u,v\nid,x,y,u,v | nodes.csv:2
1,1,2,3,4 -> | elements.csv: has no element
1,1,2,3,4 -> 1,1,2 | elements.csv:1: an element is an id and the ids of 3 or 4 nodes
1,1,2,3,4 -> 1,1,2,3,4\n2,1,2,5 | elements.csv:2: the node list has no node 5
1,1,2,3,4 -> 1,1,2,3\n1,1,3,4 | elements.csv:2: the element 1 is in line 1 already
1,1,2,3,4 -> 1,1,3,2,4 | the element 1 crosses itself
1,1,2,3,4 -> 1,1,2,3,3 | degenerate
1,1,2,3,4 -> 1,1,2,2 | degenerate
3,1,1,5,6 -> 3,0.25,0.25,5,6 | elements.csv:1: the element 1 is concave
)",
                       "fem-to-image nodes.csv --elements elements.csv --size 9 --output o.nrrd", "nodes.csv",
                       "1,0,0,5,6\n2,1,0,5,6\n3,1,1,5,6\n4,0,1,5,6\n=\n1,1,2,3,4\n", "elements.csv");
  (void)folder_.write("bad.csv", "1,0,0,0,0\n2,x,0,0,0\n");
  expect_refused_words(R"(
fem-to-image --output o.nrrd | nodes is required
fem-to-image nodes.csv --output o.nrrd | --size
fem-to-image /none.csv --size 9 --output o.nrrd | /none.csv: there is no such file
fem-to-image . --size 9 --output o.nrrd | cannot be read
fem-to-image bad.csv --size 9 --output o.nrrd | bad.csv:2: the node's x is "x"
fem-to-image nodes.csv --size 1 --output o.nrrd | origin
fem-to-image nodes.csv --size 9 --interpolation element --output o.nrrd | --elements
fem-to-image nodes.csv --size 9 --interpolation cubic --output o.nrrd | cubic
fem-to-image nodes.csv --size 9 --pixel 1 --output o.nrrd | --pixel requires --origin
fem-to-image nodes.csv --size 9 --pixel -1 --origin 0,0 --output o.nrrd | side -1
fem-to-image nodes.csv --size 9 --pixel 1e-310 --origin 0,0 --output o.nrrd | beyond
fem-to-image nodes.csv --size 2000000 --output o.nrrd | GiB of memory
fem-to-image nodes.csv --size 9 --reach -1 --output o.nrrd | reach is -1
fem-to-image nodes.csv --size 9 --output /none/o.nrrd | /none
positions-to-displacements | input is required
positions-to-displacements /none.txt o.nrrd | there is no such file
positions-to-displacements bad.csv /none/o.nrrd | /none
)");
  expect_refused_edits(
      R"(
Width=3 -> Breite=3 | raw.txt:1: Width=... with a whole number
Width=3 -> Width=three | not "Width=three"
Width=3 -> Width=0 | raw.txt:1
Width=3 -> Width=4 | raw.txt:5: row 0 of X Trans has 3 numbers, the image is 4
Width=3 -> Width=1000000000 | cannot hold
Height=2 -> Height=3 | raw.txt:8: the position is "Y"
X Trans -> Z Trans | "X Trans ---" is expected
Y Trans -> Y Trance | "Y Trans ---" is expected
1.5 -> 1.5x | raw.txt:5: the position is "1.5x"
1.5 -> nan | finite
1 1 3.25 -> | ends after 1 of 2 rows of Y Trans
1 1 3.25 -> 1 1 3.25\n0 0 0 | raw.txt:11: more rows
)",
      "positions-to-displacements raw.txt o.nrrd", "raw.txt",
      "Width=3\nHeight=2\n\nX Trans ---\n0.0 1.5 2.0\n-1.0 1 2e0\n\nY Trans ---\n0 0 0\n1 1 3.25\n");
}

/// Images in the folder, and scenes and commands that read them.
class ImageRefusals : public Refusals {
protected:
  void SetUp() override {
    if (!have_images()) {
      GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
    }
  }
  void write_nrrd(const std::string& name, const char* type, const std::string& sizes,
                  const std::string& pixels) const {
    const bool is_vector = std::ranges::count(sizes, ' ') == 2;
    (void)folder_.write(name + ".nrrd",
                        fmt::format("NRRD0004\ntype: {}\ndimension: {}\n{}sizes: {}\nencoding: ascii\n\n{}\n",
                                    type, is_vector ? 3 : 2, is_vector ? "kinds: vector domain domain\n" : "",
                                    sizes, pixels));
  }
};

TEST_F(ImageRefusals, OfScenes) {
  write_nrrd("labels", "short", "3 2", "0 7 7 0 0 7");
  write_nrrd("label-9", "short", "3 2", "0 7 7 0 9 7");
  write_nrrd("modulus", "float", "3 2", "1 2 3 4 5 6.5");
  write_nrrd("target", "float", "2 3 2", "1 2 3 4 5 6 7 8 9 10 11 12");
  write_nrrd("far", "float", "2 3 2", "1 2 3 4 5 6 7 8 9 1e30 11 12");
  write_nrrd("confidence", "float", "2 3 2", "0 1 0.5 0 0 0 0 0 0 0 1 0.25");
  write_nrrd("small", "float", "2 2 2", "0 0 0 0 0 0 0 0");
  write_nrrd("cut", "float", "2 3 2", "0 0 0 0");
  for (const char* value : {"0", "-2", "nan", "inf", "1.5", "-0.5"}) {
    write_nrrd(std::string("modulus") + value, "float", "3 2", fmt::format("1 2 3 4 {} 6", value));
    write_nrrd(std::string("confidence") + value, "float", "2 3 2",
               fmt::format("0 0 0 0 0 0 0 {} 0 0 0 0", value));
  }
  expect_refused_edits(R"(
labels = "labels.nrrd" -> | exactly one of the two
labels = "labels.nrrd" -> modulus = "modulus.nrrd" | tissue has no effect
labels.nrrd" -> labels.nrrd"\nmodulus = "modulus.nrrd" | exactly one of the two
labels.nrrd -> nowhere.nrrd | there is no such file
labels.nrrd -> scene.toml | scene.toml
labels.nrrd -> modulus.nrrd | 6.5
labels.nrrd -> label-9.nrrd | none has the label 9 of the pixel x = 1, y = 1
labels.nrrd" -> labels.nrrd"\ntarget = "target.nrrd" | give both images or none
labels.nrrd" -> labels.nrrd"\nlabel = 3 | label is not a key of scene files here; did you mean labels?
labels.nrrd" -> labels.nrrd"\ntargets = "target.nrrd"\nconfidence = "confidence.nrrd" | did you mean target?
labels.nrrd" -> labels.nrrd"\ntarget = "target.nrrd"\ndeviation = "confidence.nrrd" | deviation has no effect
[[tissue]] -> spacing = 0\n[[tissue]] | spacing is 0, it must be positive
)",
                       "run scene.toml", "scene.toml",
                       R"([[tissue]]
label = 0
modulus = 10.0
[[tissue]]
label = 7
modulus = 30.0
[image]
labels = "labels.nrrd"
)");
  expect_refused_edits(R"(
modulus.nrrd -> modulus0.nrrd | x = 1, y = 1
modulus.nrrd -> modulus-2.nrrd | x = 1, y = 1
modulus.nrrd -> modulusnan.nrrd | x = 1, y = 1
modulus.nrrd -> modulusinf.nrrd | x = 1, y = 1
confidence.nrrd -> confidence1.5.nrrd | x = 0, y = 1
confidence.nrrd -> confidence-0.5.nrrd | x = 0, y = 1
confidence.nrrd -> confidencenan.nrrd | x = 0, y = 1
confidence.nrrd -> small.nrrd | 2 x 2, the scene is 3 x 2
confidence.nrrd -> cut.nrrd | cut.nrrd
target.nrrd -> far.nrrd | target has a displacement of 1e+30 pixels; at most 1e+09 are possible
modulus.nrrd" -> modulus.nrrd"\npicture_range = [0.0, 1.0] | picture_range has no effect
[image] -> energy = "elastic"\n[image]\nstart = "target.nrrd" | start has no effect
)",
                       "run scene.toml", "scene.toml",
                       R"([image]
modulus = "modulus.nrrd"
target = "target.nrrd"
confidence = "confidence.nrrd"
)");
  (void)folder_.write("modulus.toml", "[image]\nmodulus = \"modulus.nrrd\"\n");
  expect_refused("run modulus.toml --size 8",
                 "modulus does not fill 8 x 8 pixels, which have another aspect");
}

TEST_F(ImageRefusals, OfRegistrationAndDetection) {
  constexpr int side = 64;
  const Extent extent{side, side};
  test::write_person(folder_.path(), side);
  std::map<std::string, ScalarField> pictures;
  for (const char* name : {"empty", "spoilt", "point", "corner", "noise", "left", "right"}) {
    pictures.emplace(name, extent);
  }
  pictures.emplace("everywhere", ScalarField(extent, 1.0F));
  pictures.emplace("constant", ScalarField(extent, 9.0F));
  pictures.emplace("modulus", ScalarField(extent, 20.0F));
  pictures.emplace("small", ScalarField({32, 32}));
  GaussianNoise random(1);
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    pictures["noise"].values[site] = static_cast<float>(100.0 * random.uniform());
    pictures["corner"].values[site] = x < 8 && y < 8 ? 1.0F : 0.0F;
    pictures["left"].values[site] = x == 5 && y >= 20 && y < 40 ? 200.0F : 0.0F;
    pictures["right"].values[site] = x == 50 && y >= 20 && y < 40 ? 200.0F : 0.0F;
  });
  pictures["point"].values[extent.index(30, 31)] = 1.0F;
  pictures["spoilt"].values[extent.index(30, 31)] = std::nanf("");
  for (const auto& [name, picture] : pictures) {
    write_scalar(folder_.path() / (name + ".nrrd"), picture, 1.0);
  }
  write_scalar(folder_.path() / "coarse.nrrd", pictures["noise"], 2.0);
  (void)folder_.write("volume.nrrd",
                      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 64 64 2\nencoding: raw\n\n" +
                          std::string(std::size_t{2} * side * side, 'x'));
  (void)folder_.write("unlabelled.toml", "[image]\nmodulus = \"modulus.nrrd\"\n");
  for (const char* command : {"register", "detect"}) {
    expect_refused_words(R"(
source.nrrd small.nrrd --scene person.toml | is 32 x 32 pixels, the scene person is 64 x 64
source.nrrd coarse.nrrd --scene person.toml | has pixels of 2 mm
left.nrrd right.nrrd --scene person.toml | do not overlap
source.nrrd constant.nrrd --scene person.toml | no contrast to register by
source.nrrd volume.nrrd --scene person.toml | slice
source.nrrd missing.nrrd --scene person.toml | missing.nrrd
source.nrrd target.nrrd --scene unlabelled.toml | has no labels
)",
                         command + std::string(" "), " --roi region.nrrd --output out");
    expect_refused_words(R"(
empty.nrrd | region of interest is empty
everywhere.nrrd | whole image
spoilt.nrrd | x = 30, y = 31 is nan
small.nrrd | 32 x 32
)",
                         command +
                             std::string(" source.nrrd target.nrrd --scene person.toml --output out --roi "));
  }
  expect_refused_words(R"(
detect source.nrrd target.nrrd | --roi is required
detect source.nrrd target.nrrd --roi region.nrrd --simulations 2 | --simulations
detect source.nrrd target.nrrd --roi region.nrrd --method icm | no option --method
detect source.nrrd target.nrrd --roi point.nrrd | has 1 pixels of tissue
detect source.nrrd target.nrrd --roi corner.nrrd | has 0 pixels of tissue
detect source.nrrd source.nrrd --roi region.nrrd | without a deformation
detect source.nrrd noise.nrrd --roi region.nrrd | no likeness
register source.nrrd target.nrrd --conventional magic | magic
register source.nrrd target.nrrd --iterate --energy hdm | --energy has no effect here
register source.nrrd target.nrrd --iterate --conventional demons | --conventional has no effect here
register source.nrrd target.nrrd --iterate --iterations 0 --steps fine | --iterations, --steps have no effect here
register source.nrrd target.nrrd --iterations 0 | give at least 1
register source.nrrd target.nrrd --iterat | did you mean --iterate?
)",
                       "", " --scene person.toml --output out");
  expect_refused_words(R"(
rivals person.toml --quick --other square | by pictures with labels, of one size
rivals person.toml --quick --other missing.toml | missing.toml
rivals person.toml --quick --other unlabelled.toml | pictures with labels
rivals person.toml --orientation coronal | has no other orientation
tune random --size 21 --truth positions.nrrd | is 64 x 64 pixels, the scene is 21 x 21
)");
}

TEST_F(Refusals, OfLevels) {
  // A caller of the library has no program before it.
  Level good{.extent = {7, 5},
             .target = VectorField({7, 5}),
             .confidence = VectorField({7, 5}),
             .modulus = ScalarField({7, 5}, 1.0F)};
  good.penalty = 1.0F;
  set_inverse_modulus(good);
  const auto refused = [&](float& value, float bad, const char* says) {
    const float before = std::exchange(value, bad);
    EXPECT_THAT(test::refusal([&] { validate(good); }), HasSubstr(says)) << bad;
    value = before;
  };
  EXPECT_EQ(test::refusal([&] { validate(good); }), "accepted");
  for (const float bad : {std::nanf(""), HUGE_VALF, -1.0F}) {
    refused(good.modulus.values[9], bad, "x = 2, y = 1");
    refused(good.confidence.y[9], bad, "x = 2, y = 1");
    refused(good.penalty, bad, "penalty K");
  }
  refused(good.modulus.values[9], 0.0F, "modulus");
  refused(good.modulus.values[9], 1e-39F, "its inverse");
  refused(good.confidence.x[9], 1.5F, "confidence");
  refused(good.target.x[9], std::nanf(""), "target");
  refused(good.target.y[9], -HUGE_VALF, "x = 2, y = 1");
  Level other = good;
  other.target = VectorField({5, 7});
  EXPECT_THAT(test::refusal([&] { validate(other); }), HasSubstr("5 x 7"));
  other = good;
  other.modulus.values.pop_back();
  EXPECT_THAT(test::refusal([&] { validate(other); }), HasSubstr("34 values"));
  other.extent = {0, 5};
  EXPECT_THAT(test::refusal([&] { validate(other); }), HasSubstr("at least 1"));
}

} // namespace
} // namespace hdmbench
