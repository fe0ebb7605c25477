// The texts of the kernels, after a C preprocessor, as WGSL. They use little of C; an Error names the line of what is not
// known here.

const wgsl_types = { float: "f32", int: "i32", bool: "bool", void: "" };
/** What binds tighter has a higher rank; equals are grouped from the left. */
const wgsl_ranks = { "||": 1, "&&": 2, "&": 3, "==": 4, "!=": 4, "<": 5, ">": 5, "<=": 5, ">=": 5, "<<": 6, ">>": 6, "+": 7,
  "-": 7, "*": 8, "/": 8 };
/** Names in the texts that WGSL keeps for itself. */
const wgsl_reserved = new Set(["from", "move", "of", "target"]);

class Wgsl {
  constructor(text) {
    this.lines = text.split("\n");
    this.tokens = this.lines.flatMap((line, number) =>
      (line.match(/[A-Za-z_]\w*|0x[0-9A-F]+|\d+\.?\d*(?:[eE][-+]?\d+)?|\+\+|<<|>>|[-+<>=!]=|&&|\|\||\S/g) || []).map((token) => ({ token, number })));
    this.types = { ...wgsl_types };
    this.changed = new Set(); // variables that a function assigns to, or to what is in them
    this.at = 0;
  }

  peek(ahead = 0) { return this.at + ahead < this.tokens.length ? this.tokens[this.at + ahead].token : ""; }

  next() {
    this.at += 1;
    return this.peek(-1);
  }

  fail() {
    const { number } = this.tokens[Math.min(this.at, this.tokens.length - 1)];
    throw new Error("no WGSL is known for \"" + this.peek() + "\" in: " + this.lines[number].trim());
  }

  /** Whether this comes next; then it is taken. */
  skip(token) {
    if (this.peek() !== token) { return false; }
    this.at += 1;
    return true;
  }

  take(token) { if (!this.skip(token)) { this.fail(); } }

  name() {
    if (!/^[A-Za-z_]/.test(this.peek())) { this.fail(); }
    const name = this.next();
    return wgsl_reserved.has(name) ? name + "_" : name;
  }

  type() {
    if (!Object.hasOwn(this.types, this.peek())) { this.fail(); }
    return this.types[this.next()];
  }

  /** "name: type" of a variable whose type C has before and an array's lengths behind the name. */
  variable(type) {
    const name = this.name();
    const lengths = [];
    while (this.skip("[")) {
      lengths.push(this.expression());
      this.take("]");
    }
    return name + ": " + lengths.reduceRight((of, length) => "array<" + of + ", " + length + ">", type);
  }

  /** What stands between commas until `end`. */
  list(end, item) {
    const items = [];
    while (!this.skip(end)) {
      if (items.length > 0) { this.take(","); }
      items.push(item());
    }
    return items.join(", ");
  }

  /** WGSL wants brackets where C knows ranks, writes ?: in another order, and shifts by unsigned numbers. */
  expression() {
    const text = this.binary(1);
    if (!this.skip("?")) { return text; }
    const yes = this.expression();
    this.take(":");
    return "select(" + this.expression() + ", " + yes + ", " + text + ")";
  }

  /** Reads what operators of this rank or a higher one bind. */
  binary(least) {
    let text = this.operand();
    while (wgsl_ranks[this.peek()] >= least) {
      const operator = this.next();
      const right = this.binary(wgsl_ranks[operator] + 1);
      text = "(" + text + " " + operator + " " + (/<<|>>/.test(operator) ? "u32(" + right + ")" : right) + ")";
    }
    return text;
  }

  operand() {
    if (this.skip("-")) { return "-" + this.operand(); }
    if (this.skip("!")) { return "!" + this.operand(); }
    if (this.skip("(")) {
      const inner = this.expression();
      this.take(")");
      return "(" + inner + ")";
    }
    if (/^\d/.test(this.peek())) { return this.next(); }
    return this.place(Object.hasOwn(this.types, this.peek()) ? this.type() : this.name());
  }

  /** A name with its calls, members and indices. */
  place(text) {
    for (;;) {
      if (this.skip("(")) {
        text += "(" + this.list(")", () => this.expression()) + ")";
      } else if (this.skip("[")) {
        text += "[" + this.expression() + "]";
        this.take("]");
      } else if (this.skip(".")) {
        text += "." + this.name();
      } else {
        return text;
      }
    }
  }

  /** Reads what stands between commas: declarations, assignments, ++name or a call, without what ends them. */
  simple() {
    this.skip("const");
    const type = Object.hasOwn(this.types, this.peek()) ? this.type() : null;
    const parts = [];
    do {
      const steps = this.skip("++");
      const left = type ? "var " + this.variable(type) : this.place(this.name());
      const operator = steps ? "++" : ["=", "+=", "-="].find((one) => this.skip(one));
      if (operator && !type) { this.changed.add(left.match(/\w+/)[0]); }
      parts.push(operator === "++" ? left + "++" : operator ? left + " " + operator + " " + this.expression() : left);
    } while (this.skip(","));
    return parts;
  }

  in_brackets() {
    this.take("(");
    const text = this.expression();
    this.take(")");
    return " (" + text + ") ";
  }

  statement() {
    if (this.skip("if")) {
      const text = "if" + this.in_brackets() + this.block();
      return this.skip("else") ? text + "else " + (this.peek() === "if" ? this.statement() : this.block()) : text;
    }
    if (this.skip("while")) { return "while" + this.in_brackets() + this.block(); }
    if (this.skip("for")) {
      this.take("(");
      const before = this.simple();
      this.take(";");
      const goes_on = this.expression();
      this.take(";");
      const after = this.simple();
      this.take(")");
      const loop = "for (" + before.shift() + "; " + goes_on + "; " + after.join(", ") + ") " + this.block();
      return before.length > 0 ? "{\n" + before.join(";\n") + ";\n" + loop + "}\n" : loop;
    }
    if (this.peek() === "{") { return this.block(); }
    if (this.skip(";")) { return ""; }
    const text = !this.skip("return") ? this.simple().join(";\n") : this.peek() === ";" ? "return" : "return " + this.expression();
    this.take(";");
    return text + ";\n";
  }

  block() {
    this.take("{");
    let text = "{\n";
    while (!this.skip("}")) { text += this.statement(); }
    return text + "}\n";
  }

  structure() {
    const name = this.name();
    this.types[name] = name;
    this.take("{");
    let text = "struct " + name + " {\n";
    while (!this.skip("}")) {
      const type = this.type();
      do { text += this.variable(type) + ",\n"; } while (this.skip(","));
      this.take(";");
    }
    this.take(";");
    return text + "}\n";
  }

  constant() {
    const text = "const " + this.variable(this.type());
    this.take("=");
    const value = this.expression();
    this.take(";");
    return text + " = " + value + ";\n";
  }

  /** Defines a variable or a function. WGSL assigns to no parameter: those that change become variables. */
  definition() {
    const type = this.type();
    if (this.peek(1) === ";") {
      const variable = "var<private> " + this.variable(type) + ";\n";
      this.take(";");
      return variable;
    }
    const name = this.name();
    this.take("(");
    const names = [];
    let parameters = this.list(")", () => {
      this.skip("const");
      const parameter = this.variable(this.type());
      names.push(parameter.match(/\w+/)[0]);
      return parameter;
    });
    this.changed.clear();
    let block = this.block();
    for (const changed of names.filter((one) => this.changed.has(one))) {
      parameters = parameters.replace(new RegExp("\\b" + changed + ":"), changed + "_given:");
      block = block.replace("{\n", "{\nvar " + changed + " = " + changed + "_given;\n");
    }
    return "fn " + name + "(" + parameters + ")" + (type ? " -> " + type : "") + " " + block;
  }

  translation() {
    let text = "";
    while (this.at < this.tokens.length) {
      text += this.skip("struct") ? this.structure() : this.skip("const") ? this.constant() : this.definition();
    }
    return text;
  }
}
