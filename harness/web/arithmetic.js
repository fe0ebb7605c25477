// What a GPU's arithmetic does, as `hdmbench probe` asks it: the same cases of the same operations.

/** One answer as a row of `probe`'s results; `found` has a number for each case. -0 is not 0 here, and any NaN is NaN. */
function answer(gpu, question, specified, other, found) {
  const row = {
    backend: gpu.backend, device: gpu.device, driver: gpu.driver, program: gpu.language, question: question.question,
    as_specified: question.as_specified, otherwise: question.otherwise, answer: "untold", telling: 0, specified: 0, other: 0
  };
  let strange = false;
  found.forEach((value, i) => {
    const tells = !Object.is(specified[i], other[i]);
    row.telling += tells ? 1 : 0;
    row.specified += tells && Object.is(value, specified[i]) ? 1 : 0;
    row.other += tells && Object.is(value, other[i]) ? 1 : 0;
    strange = strange || !(Object.is(value, specified[i]) || Object.is(value, other[i]));
  });
  if (strange) {
    row.answer = "neither";
  } else if (row.telling > 0) {
    row.answer = row.specified === row.telling ? "as specified" : row.other === row.telling ? "otherwise" : "mixed";
  }
  return row;
}

async function ask(gpu, questions) {
  const rows = [];
  for (const question of questions) {
    const numbers = floats(question.numbers); // eight of each case; what each should come to, and what else it could
    const count = numbers.length / 10;
    const found = await gpu.evaluate(numbers.slice(0, 8 * count));
    rows.push(answer(gpu, question, numbers.slice(8 * count, 9 * count), numbers.slice(9 * count), found));
  }
  return rows;
}
