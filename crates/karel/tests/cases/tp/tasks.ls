/PROG  TASKS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  RUN ACTION ;
   2:  WAIT .10(sec) ;
   3:  R[7]=R[2] ;
   4:  CALL ACTION ;
   5:  PAUSE ;
   6:  R[8]=1 ;
   7:  ABORT ;
   8:  R[8]=2 ;
/POS
/END
--> continue
--> load action.ls
