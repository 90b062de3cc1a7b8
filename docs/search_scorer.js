// Order of search results: how-tos before the article, both before the reference and the list of changes; of how-tos,
// those whose title has the words.
const FOLDERS = [["how-to/", 30], ["teach/", 20], ["method", 15], ["five-minutes", 15], ["reference/", 0], ["_modules/", -40], ["changes", -40]];
const WORDS = (new URLSearchParams(window.location.search).get("q") || "").toLowerCase().trim();
var Scorer = {
  score: ([docname, title, , , score]) =>
    score + (FOLDERS.find(([folder]) => docname.startsWith(folder)) || [, 0])[1] + (title.toLowerCase().includes(WORDS) ? 10 : 0),
  objNameMatch: 11, objPartialMatch: 6, objPrio: {0: 15, 1: 5, 2: -5}, objPrioDefault: 0,
  title: 15, partialTitle: 7, term: 5, partialTerm: 2,
};
