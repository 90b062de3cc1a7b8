// Order of search results: how-tos before the article, both before the reference and the list of changes.
const FOLDERS = [["how-to/", 30], ["teach/", 20], ["method", 15], ["five-minutes", 15], ["reference/", 0], ["_modules/", -40], ["changes", -40]];
var Scorer = {
  score: ([docname, , , , score]) => score + (FOLDERS.find(([folder]) => docname.startsWith(folder)) || [, 0])[1],
  objNameMatch: 11, objPartialMatch: 6, objPrio: {0: 15, 1: 5, 2: -5}, objPrioDefault: 0,
  title: 15, partialTitle: 7, term: 5, partialTerm: 2,
};
