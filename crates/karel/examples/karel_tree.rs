fn main(){ let f=std::env::args().nth(1).unwrap(); let b=std::fs::read(&f).unwrap(); match karel::syntax_tree(&b,&f){Ok(t)=>println!("{t}"),Err(e)=>println!("{}",karel::render(&e))} }
