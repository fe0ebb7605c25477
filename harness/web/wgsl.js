// The texts of kernels/specification, after a C preprocessor, as WGSL. They use little of C; an Error names the line of
// what is not known here.

const wgsl_types = { float: "f32", int: "i32", bool: "bool" };
const wgsl_operators = new Set(["+", "-", "*", "/", "<", ">", "<=", ">=", "==", "!=", "&&", "||"]);
/** Names in the texts that WGSL keeps for itself. */
const wgsl_reserved = new Set(["move", "of", "target"]);

class Wgsl {
  constructor(text) {
    this.lines = text.split("\n");
    this.tokens = this.lines.flatMap((line, number) =>
      (line.match(/[A-Za-z_]\w*|\d+\.?\d*(?:[eE][-+]?\d+)?|\+\+|[<>=!]=|&&|\|\||\S/g) || []).map((token) => ({ token, number })));
    this.types = { ...wgsl_types };
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

  /** "name: type" of a variable whose type C has before and an array's length behind the name. */
  variable(type) {
    const name = this.name();
    if (!this.skip("[")) { return name + ": " + type; }
    const length = this.expression();
    this.take("]");
    return name + ": array<" + type + ", " + length + ">";
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

  /** Both languages rank the operators that are known here alike, and both group equal ones from the left: only ?: is
      written in another order. */
  expression() {
    let text = this.operand();
    while (wgsl_operators.has(this.peek())) { text += " " + this.next() + " " + this.operand(); }
    if (!this.skip("?")) { return text; }
    const yes = this.expression();
    this.take(":");
    return "select(" + this.expression() + ", " + yes + ", " + text + ")";
  }

  operand() {
    if (this.skip("-")) { return "-" + this.operand(); }
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

  /** A declaration, an assignment or ++name, without what ends it. */
  simple() {
    if (this.skip("++")) { return this.name() + "++"; }
    this.skip("const");
    const declares = Object.hasOwn(this.types, this.peek());
    const left = declares ? "var " + this.variable(this.type()) : this.place(this.name());
    return this.skip("=") ? left + " = " + this.expression() : left;
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
      const parts = [this.simple()];
      this.take(";");
      parts.push(this.expression());
      this.take(";");
      parts.push(this.simple());
      this.take(")");
      return "for (" + parts.join("; ") + ") " + this.block();
    }
    const text = this.skip("return") ? "return " + this.expression() : this.simple();
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

  definition() {
    const type = this.type();
    const name = this.name();
    this.take("(");
    const parameters = this.list(")", () => {
      this.skip("const");
      return this.variable(this.type());
    });
    return "fn " + name + "(" + parameters + ") -> " + type + " " + this.block();
  }

  translation() {
    let text = "";
    while (this.at < this.tokens.length) {
      text += this.skip("struct") ? this.structure() : this.skip("const") ? this.constant() : this.definition();
    }
    return text;
  }
}
