//! Reads the annotated item.
//!
//! In: its tokens. Out: a function or an `impl` block, parsed only as far as needed: bodies stay tokens, so that only
//! the compiler checks them.

use proc_macro2::{TokenStream, TokenTree};
use quote::{ToTokens, TokenStreamExt, quote};
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Generics, Signature, Token, Type, Visibility, braced, token};

use crate::attribute::{Arguments, Kind};
use crate::errors::Errors;

/// A function, parsed except for its body.
pub struct Function {
    pub attributes: Vec<Attribute>,
    pub visibility: Visibility,
    pub signature: Signature,
    body: TokenStream,
}

impl Parse for Function {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        Ok(Function {
            attributes: input.call(Attribute::parse_outer)?,
            visibility: input.parse()?,
            signature: input.parse()?,
            body: input.parse()?,
        })
    }
}

impl Function {
    /// The function as it was written, with one more line of documentation.
    pub fn with_doc(&self, line: &str) -> TokenStream {
        let Function { attributes, visibility, signature, body } = self;
        let has_docs = attributes.iter().any(|attribute| attribute.path().is_ident("doc"));
        let blank = has_docs.then(|| quote!(#[doc = ""]));
        let line = format!(" {line}");
        let outer = Outer(attributes);
        quote!(#outer #blank #[doc = #line] #visibility #signature #body)
    }

    /// The `doc` attributes.
    pub fn docs(&self) -> impl Iterator<Item = &Attribute> {
        self.attributes.iter().filter(|attribute| attribute.path().is_ident("doc"))
    }
}

/// Attributes printed one after another.
struct Outer<'a>(&'a [Attribute]);

impl ToTokens for Outer<'_> {
    fn to_tokens(&self, tokens: &mut TokenStream) {
        tokens.append_all(self.0);
    }
}

/// The `cfg` attributes among `attributes`: they apply to what is generated beside the item as well.
pub fn cfgs(attributes: &[Attribute]) -> Vec<Attribute> {
    attributes.iter().filter(|attribute| attribute.path().is_ident("cfg")).cloned().collect()
}

/// An inherent `impl` block: its header and its methods.
pub struct Block {
    pub attributes: Vec<Attribute>,
    pub generics: Generics,
    pub self_type: Type,
    pub methods: Vec<Signature>,
}

impl Parse for Block {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        input.parse::<Option<Token![unsafe]>>()?;
        input.parse::<Token![impl]>()?;
        let mut generics: Generics = if input.peek(Token![<]) { input.parse()? } else { Generics::default() };
        let self_type = input.parse()?;
        if input.peek(Token![for]) {
            return Err(input.error(
                "this stands over an inherent block, `impl Carry { .. }`, not over the impl of a trait",
            ));
        }
        generics.where_clause = input.parse()?;
        let content;
        braced!(content in input);
        content.call(Attribute::parse_inner)?;
        let mut methods = Vec::new();
        while !content.is_empty() {
            content.call(Attribute::parse_outer)?;
            content.parse::<Visibility>()?;
            let ahead = content.fork();
            if let Ok(signature) = ahead.parse::<Signature>() {
                content.parse::<Signature>()?;
                methods.push(signature);
            }
            skip_item(&content)?;
        }
        Ok(Block { attributes, generics, self_type, methods })
    }
}

/// Skips to the end of an associated item: past `;` or `{ .. }`.
fn skip_item(input: ParseStream<'_>) -> syn::Result<()> {
    let constant = input.peek(Token![const]) || input.peek(Token![type]);
    while !input.is_empty() {
        let end = input.peek(Token![;]) || (input.peek(token::Brace) && !constant);
        input.parse::<TokenTree>()?;
        if end {
            break;
        }
    }
    Ok(())
}

/// The item over which an attribute stands.
pub enum Item {
    Function(Function),
    Block(Block),
}

impl Parse for Item {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let ahead = input.fork();
        ahead.call(Attribute::parse_outer)?;
        if ahead.peek(Token![impl]) || (ahead.peek(Token![unsafe]) && ahead.peek2(Token![impl])) {
            return input.parse().map(Item::Block);
        }
        ahead.parse::<Visibility>()?;
        if ["struct", "enum", "trait", "union", "mod", "type", "static", "use", "macro_rules"]
            .iter()
            .any(|keyword| ahead.cursor().ident().is_some_and(|(ident, _)| ident == keyword))
        {
            return Err(ahead.error(
                "this stands over a step function, `fn carry(c: &mut Carry, ..) -> Step<..> { .. }`, or over an `impl` block that holds one",
            ));
        }
        input.parse().map(Item::Function)
    }
}

/// A front end for items of the form `T`: expands one of them, with the mistakes found so far.
type FrontEnd<T> = fn(&Arguments, &T, Errors, &TokenStream) -> TokenStream;

/// Reads the attribute and the item and passes them to the front end of the item's form. An item that is neither a
/// function nor a block is returned with the error.
pub fn expand(
    kind: Kind,
    attribute: TokenStream,
    item: TokenStream,
    of_function: FrontEnd<Function>,
    of_block: FrontEnd<Block>,
) -> TokenStream {
    let mut errors = Errors::default();
    let arguments = Arguments::parse(kind, attribute, &mut errors);
    match syn::parse2(item.clone()) {
        Ok(Item::Function(function)) => of_function(&arguments, &function, errors, &item),
        Ok(Item::Block(block)) => of_block(&arguments, &block, errors, &item),
        Err(error) => {
            errors.add(error);
            let errors = errors.into_tokens();
            quote!(#item #errors)
        }
    }
}
